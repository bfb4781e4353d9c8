//! Whole renders, timed: samples and rays per second, and what each pass takes of it.

use serde::Serialize;

use device::Device;

use engine::{
    procedural::Procedural,
    renderer::{RenderError, RenderSettings, Renderer},
    scene::Scene,
    stats::Stats,
    wave::PathBytes,
};

use crate::spread::Spread;

/// One of the things that are timed in turn.
#[derive(Debug)]
pub struct Workload<'a> {
    /// What it is called in the report.
    pub name: String,
    /// What is rendered.
    pub scene: &'a Scene,
    /// Its texture programs.
    pub procedural: &'a Procedural,
    /// How it is rendered.
    pub settings: RenderSettings,
}

/// Rays of one kind.
#[derive(Debug, Clone, Serialize)]
pub struct Rays {
    /// Rays of a run.
    pub rays: u64,
    /// Million rays per second of the time of the pass that traces them; of wall time without timestamps.
    pub mrays_per_second: Spread,
}

/// A kernel.
#[derive(Debug, Clone, Serialize)]
pub struct Pass {
    /// Its name.
    pub name: String,
    /// On the device, of a run; zeros without timestamps.
    pub milliseconds: Spread,
    /// Median part of the time of all passes, 0 to 1.
    pub share: f64,
    /// Dispatches of a run, those without work included.
    pub dispatches: u64,
}

/// What was measured of a workload.
#[derive(Debug, Clone, Serialize)]
pub struct RenderReport {
    /// What it is called.
    pub name: String,
    /// Triangles, those of each instance counted.
    pub triangles: u64,
    /// Camera paths of a run.
    pub samples: u64,
    /// Camera paths finished per second of wall time.
    pub samples_per_second: Spread,
    /// Rays to their closest hit.
    pub closest: Rays,
    /// Shadow rays, to any hit.
    pub occlusion: Rays,
    /// Rays of ambient occlusion.
    pub ao: Rays,
    /// In the order in which a wave runs them.
    pub passes: Vec<Pass>,
    /// Samples of all runs that were not finite.
    pub invalid_samples: u64,
    /// GPU memory of one path.
    pub path_bytes: PathBytes,
    /// Whether passes were timed on the device.
    pub timestamps: bool,
}

/// One timed render of a workload: the difference of the renderer's totals before and after it.
struct Run {
    seconds: f64,
    closest: u64,
    occlusion: u64,
    ao: u64,
    /// Milliseconds and dispatches of each pass.
    passes: Vec<(f64, u64)>,
    invalid: u64,
}

impl Run {
    fn between(before: &Stats, after: &Stats) -> Self {
        let closest = |stats: &Stats| stats.rays - stats.ao_rays - stats.shadow_rays;
        let earlier = |name: &str| {
            let pass = before.passes.iter().find(|pass| pass.name == name);
            pass.map_or((0.0, 0), |pass| (pass.milliseconds, pass.dispatches))
        };
        let pass = |pass: &engine::stats::PassStats| {
            let (milliseconds, dispatches) = earlier(&pass.name);
            (
                pass.milliseconds - milliseconds,
                pass.dispatches - dispatches,
            )
        };
        Self {
            seconds: after.seconds - before.seconds,
            closest: closest(after) - closest(before),
            occlusion: after.shadow_rays - before.shadow_rays,
            ao: after.ao_rays - before.ao_rays,
            passes: after.passes.iter().map(pass).collect(),
            invalid: after.invalid_samples - before.invalid_samples,
        }
    }
}

/// How often everything is rendered.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Samples of each pixel.
    pub spp: u32,
    /// Timed runs.
    pub runs: u32,
    /// Asked again and again whether to end with the runs that are done.
    pub is_over: fn() -> bool,
}

/// Renders every workload so many times, in turn (A B C A B C), after one run of each that is not counted: drivers compile kernels
/// when they run for the first time. `progress` hears of each render, and how many timed runs all workloads have by then. The
/// number of these comes with the reports.
///
/// # Errors
/// As [`Renderer::new`] and [`Renderer::render`].
pub fn render(
    device: &Device,
    workloads: &[Workload<'_>],
    effort: Effort,
    mut progress: impl FnMut(u32),
) -> Result<(Vec<RenderReport>, u32), RenderError> {
    let Effort { spp, runs, is_over } = effort;
    let mut renderers = Vec::new();
    for workload in workloads {
        let mut renderer = Renderer::new(
            device,
            workload.scene,
            workload.procedural,
            &workload.settings,
        )?;
        renderer.time_passes()?;
        renderers.push(renderer);
    }
    let mut timed: Vec<Vec<Run>> = workloads.iter().map(|_| Vec::new()).collect();
    let mut done = 0;
    'all: for round in 0..=runs {
        for (at, renderer) in renderers.iter_mut().enumerate() {
            renderer.restart();
            // Faster code of textures would else come in the midst of a run.
            renderer.device().finish_compiling();
            let before = renderer.stats()?;
            loop {
                if is_over() {
                    break 'all;
                }
                if renderer.step(spp)?.is_done() {
                    break;
                }
            }
            if round > 0 {
                timed[at].push(Run::between(&before, &renderer.stats()?));
            }
            if at + 1 == workloads.len() {
                done = round;
            }
            progress(done);
        }
    }
    let reports = workloads.iter().zip(&renderers).zip(&timed);
    let reports = reports.map(|((workload, renderer), runs)| {
        // All have been run as often.
        report(workload, renderer, spp, &runs[..done as usize])
    });
    Ok((reports.collect::<Result<_, _>>()?, done))
}

fn report(
    workload: &Workload<'_>,
    renderer: &Renderer,
    spp: u32,
    runs: &[Run],
) -> Result<RenderReport, RenderError> {
    let stats = renderer.stats()?;
    let RenderSettings { width, height, .. } = workload.settings;
    let samples = u64::from(width) * u64::from(height) * u64::from(spp);
    let place = |name: &str| stats.passes.iter().position(|pass| pass.name == name);
    let rays = |count: fn(&Run) -> u64, pass: &str| {
        let place = place(pass).filter(|_| stats.timestamps);
        let seconds = |run: &Run| place.map_or(run.seconds, |place| run.passes[place].0 * 1e-3);
        Rays {
            rays: runs.first().map_or(0, count),
            mrays_per_second: Spread::of(
                (runs.iter()).map(|run| rate(count(run), seconds(run)) * 1e-6),
            ),
        }
    };
    let passes = stats.passes.iter().enumerate().map(|(place, pass)| Pass {
        name: pass.name.clone(),
        milliseconds: Spread::of(runs.iter().map(|run| run.passes[place].0)),
        share: Spread::of(runs.iter().map(|run| {
            let all: f64 = run
                .passes
                .iter()
                .map(|(milliseconds, _)| milliseconds)
                .sum();
            if all > 0.0 {
                run.passes[place].0 / all
            } else {
                0.0
            }
        }))
        .median,
        dispatches: runs.first().map_or(0, |run| run.passes[place].1),
    });
    Ok(RenderReport {
        name: workload.name.clone(),
        triangles: workload.scene.instanced_triangles(),
        samples,
        samples_per_second: Spread::of(runs.iter().map(|run| rate(samples, run.seconds))),
        closest: rays(|run| run.closest, "traverse_closest"),
        occlusion: rays(|run| run.occlusion, "traverse_occlusion"),
        ao: rays(|run| run.ao, "ao"),
        passes: passes.collect(),
        invalid_samples: runs.iter().map(|run| run.invalid).sum(),
        path_bytes: renderer.path_bytes(),
        timestamps: stats.timestamps,
    })
}

fn rate(count: u64, seconds: f64) -> f64 {
    if seconds > 0.0 {
        count as f64 / seconds
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::atomic::{AtomicU32, Ordering};

    use device::DeviceChoice;
    use engine::procedural::TextureSources;
    use engine::scene::look::Look;

    use super::*;
    use crate::scenes;

    #[test]
    fn what_is_ended_early_has_the_runs_that_all_have() {
        let device = Device::open(&DeviceChoice::Native(2));
        let device = device.unwrap_or_else(|error| panic!("{error}"));
        let mut scene = scenes::cornell_box();
        let nothing = Look::parse(Path::new(""), "").unwrap_or_else(|error| panic!("{error}"));
        let procedural = Procedural::build(&nothing, &mut scene, &TextureSources::default());
        let procedural = procedural.unwrap_or_else(|error| panic!("{error}"));
        let workload = |name: &str| Workload {
            name: name.to_owned(),
            scene: &scene,
            procedural: &procedural,
            settings: RenderSettings::new(16, 16, &scene.cameras[0]),
        };
        let workloads = [workload("a"), workload("b")];
        // After the first one's second timed run.
        static RENDERS: AtomicU32 = AtomicU32::new(0);
        let effort = Effort {
            spp: 1,
            runs: 3,
            is_over: || RENDERS.load(Ordering::Relaxed) > 4,
        };
        let mut heard = Vec::new();
        let ended = render(&device, &workloads, effort, |runs| {
            RENDERS.fetch_add(1, Ordering::Relaxed);
            heard.push(runs);
        });
        let (reports, runs) = ended.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((heard, runs), (vec![0, 0, 0, 1, 1], 1));
        for report in reports {
            let Spread { median, low, high } = report.samples_per_second;
            assert!(low > 0.0 && low == median && median == high);
        }
    }
}
