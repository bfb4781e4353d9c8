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

/// Renders every workload `runs` times at `spp` samples per pixel, in turn (A B C A B C), after one run of each that is
/// not counted: drivers compile kernels when they run for the first time. `progress` hears the number of renders done.
///
/// # Errors
/// As [`Renderer::new`] and [`Renderer::render`].
pub fn render(
    device: &Device,
    workloads: &[Workload<'_>],
    spp: u32,
    runs: u32,
    mut progress: impl FnMut(u32),
) -> Result<Vec<RenderReport>, RenderError> {
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
    for round in 0..=runs {
        for (renderer, timed) in renderers.iter_mut().zip(&mut timed) {
            renderer.restart();
            let before = renderer.stats()?;
            renderer.render(spp)?;
            if round > 0 {
                timed.push(Run::between(&before, &renderer.stats()?));
            }
            done += 1;
            progress(done);
        }
    }
    let reports = workloads.iter().zip(&renderers).zip(&timed);
    reports
        .map(|((workload, renderer), runs)| report(workload, renderer, spp, runs))
        .collect()
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
