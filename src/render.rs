//! `patina render`: loads, renders, writes. Reads in the order things happen.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use device::{Device, DeviceOptions};
use engine::film::{Origin, Part};
use engine::fingerprint::fingerprint;
use engine::renderer::{RenderSettings, TextureCosts};
use engine::scene::{Camera, Scene};
use engine::session::{Inputs, Opening, Session, SessionError};
use engine::system::System;

use crate::failure::Failure;
use crate::job::RenderJob;
use crate::output;
use crate::progress::Bar;
use crate::report::{Report, Seconds};
use crate::{cache, console, crash, interrupt, library};

/// Most of the time that goes into measuring textures, where figures are asked for.
const COSTS: Duration = Duration::from_secs(5);
/// Most of the time that an interrupted render goes on for, so that a film is even.
const FAREWELL: Duration = Duration::from_secs(1);

/// Renders a scene and writes the pictures. A signal ends the rendering early, not the writing.
///
/// # Errors
/// Anything that keeps even one of the results from being written.
pub(crate) fn run(job: &RenderJob) -> Result<(), Failure> {
    let written: Vec<PathBuf> = job
        .outputs
        .paths()
        .chain(&job.stats_json)
        .cloned()
        .collect();
    let named: Vec<PathBuf> = job.look.iter().chain([&job.scene]).cloned().collect();
    output::check_all(&written, &named)?;
    let inputs = Inputs {
        scene: job.scene.clone(),
        look: job.look.clone(),
        textures: library::texture_dirs(&job.texture_dirs, job.look.as_deref())?,
        camera: None,
    };

    let bar = Bar::new("loading the scene");
    let clock = Instant::now();
    let mut opening = Opening::read(inputs, System::default())?;
    bar.suspend(|| console::diagnostics(&opening.loaded().warnings));
    // What else was read is known only now.
    output::check_all(&written, &opening.files())?;
    if let Some(wanted) = &job.camera {
        let camera = find_camera(&opening.loaded().scene, wanted)?;
        opening = opening.seen_by(camera);
    }
    let load_seconds = clock.elapsed().as_secs_f64();

    bar.stage("preparing the device");
    let clock = Instant::now();
    let cache = cache::folder();
    let device = Device::open_with(&DeviceOptions::new(&job.device).with_cache(cache.as_deref()))
        .map_err(Failure::because)?;
    bar.follow(&device);
    let mut marker = None;
    let procedural = &opening.loaded().procedural;
    if !procedural.is_empty() {
        let kernel = procedural.kernel().wgsl;
        let (own, has_crashed) =
            crash::Marker::set(cache.as_deref(), &kernel, device.description());
        if has_crashed {
            bar.suspend(|| console::warning(crash::SUSPICION));
            let tell = |texture: &str| bar.stage(&format!("building {texture} alone"));
            crash::find(procedural, device.description().index, tell)?;
            bar.stage("preparing the device");
        }
        marker = own;
    }
    // Nobody waits for a render that would begin anew on another device.
    let (own, settings) = (device.clone(), settings(job, &opening.loaded().camera));
    let mut session = opening
        .start(
            Arc::new(move || own.check().map(|()| own.clone())),
            Arc::new(move |camera| RenderSettings {
                camera,
                ..settings.clone()
            }),
        )
        .map_err(failure)?;
    let settings_written = fingerprint(session.scene(), session.procedural(), session.settings());
    if job.stats || job.stats_json.is_some() {
        session.time_passes().map_err(failure)?;
    }
    let prepare_seconds = clock.elapsed().as_secs_f64();

    let clock = Instant::now();
    let first = || {
        // Some drivers compile a kernel when it runs for the first time.
        drop(marker.take());
        interrupt::has_results();
        // A cache that can't be written costs time at the next start, nothing else.
        let _ = device.save_cache();
    };
    let complete = accumulate(&mut session, job.spp.get(), &bar, first)?;
    let mut film = session.snapshot().map_err(failure)?.film;
    interrupt::writes_results();
    if !complete && !job.outputs.films.is_empty() {
        let (_, most) = film.sample_bounds();
        complete_sample(&mut session, most)?;
        film = session.snapshot().map_err(failure)?.film;
    }
    let render_seconds = clock.elapsed().as_secs_f64();
    bar.finish();

    let (lowest, most) = film.sample_bounds();
    if !complete {
        console::warning(&format!(
            "interrupted: every pixel has at least {lowest} of {} samples",
            job.spp
        ));
    }
    let stats = session.stats().map_err(failure)?;
    for doubt in stats.doubts() {
        console::warning(&doubt.to_string());
    }
    let name = &device.description().name;
    let origin = Origin::new(name, &job.scene, job.look.as_deref(), settings_written);
    let samples = job.first_sample..job.first_sample + most;
    let part = Part::new(film, samples, origin);
    let mut outcome = output::write_or_keep(&job.outputs, &part, job.exposure);

    if job.stats || job.stats_json.is_some() {
        let seconds = Seconds {
            load: load_seconds,
            prepare: prepare_seconds,
            render: render_seconds,
        };
        let textures = texture_costs(&mut session)?;
        let report = Report::new(
            job,
            device.description(),
            &part.film,
            seconds,
            stats,
            textures,
        );
        if job.stats {
            console::print(&report.table());
        }
        if let Some(path) = &job.stats_json {
            outcome = outcome.and(report.write_json(path).map_err(Failure::because));
        }
    }
    match complete {
        true => outcome,
        false => outcome.and(Err(Failure::Interrupted)),
    }
}

/// A session's failure, but that no look is kept when the device is lost: none was edited.
fn failure(error: SessionError) -> Failure {
    match error {
        SessionError::Lost(error) => Failure::because(error),
        other => other.into(),
    }
}

/// What textures cost, as far as that can be measured in a moment.
fn texture_costs(session: &mut Session) -> Result<TextureCosts, Failure> {
    let clock = Instant::now();
    loop {
        let costs = session.measure_costs().map_err(failure)?;
        if costs.is_done || clock.elapsed() > COSTS || interrupt::requested() {
            return Ok(costs.clone());
        }
    }
}

fn settings(job: &RenderJob, camera: &Camera) -> RenderSettings {
    RenderSettings {
        max_depth: job.max_depth,
        seed: job.seed,
        energy_compensation: job.energy_compensation,
        first_sample: job.first_sample,
        filter: job.filter,
        clamp: job.clamp,
        estimator: job.estimator,
        roulette: job.roulette,
        sampler: job.sampler,
        layers: job.layers.clone(),
        filter_width: job.filter_width,
        ..RenderSettings::new(job.width, job.height, camera)
    }
}

/// Renders wave by wave, with something to do after the first; returns whether all samples were taken before the user asked to stop.
fn accumulate(
    session: &mut Session,
    spp: u32,
    bar: &Bar,
    after_first: impl FnOnce(),
) -> Result<bool, Failure> {
    let mut after_first = Some(after_first);
    loop {
        let progress = session.step(spp).map_err(failure)?;
        if let Some(after_first) = after_first.take() {
            after_first();
        }
        bar.update(&progress, spp);
        if progress.samples_done >= progress.samples_total {
            return Ok(true);
        }
        if interrupt::requested() {
            return Ok(false);
        }
    }
}

/// Gives all pixels the same samples, as a film that is to be merged should have: if that is a matter of moments, because
/// whoever ends a render doesn't wait for long.
fn complete_sample(session: &mut Session, spp: u32) -> Result<(), Failure> {
    let clock = Instant::now();
    while clock.elapsed() < FAREWELL {
        if session.step(spp).map_err(failure)?.is_done() {
            break;
        }
    }
    Ok(())
}

/// The camera of that name, or the one of that number where no name fits.
fn find_camera(scene: &Scene, wanted: &str) -> Result<Camera, Failure> {
    let by_name = scene.cameras.iter().find(|camera| camera.name == wanted);
    let by_number = || scene.cameras.get(wanted.parse::<usize>().ok()?);
    by_name.or_else(by_number).cloned().ok_or_else(|| {
        let names: Vec<_> = scene
            .cameras
            .iter()
            .map(|camera| format!("'{}'", camera.name))
            .collect();
        Failure::Failed(if names.is_empty() {
            format!("--camera {wanted}: the scene has no cameras; leave the flag out for a view of everything")
        } else {
            format!(
                "--camera {wanted}: the scene has no camera of this name; it has {}",
                names.join(", ")
            )
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::scene::Projection;

    fn scene(names: &[&str]) -> Scene {
        let cameras = names
            .iter()
            .map(|&name| Camera {
                name: name.to_owned(),
                transform: glam::Affine3A::IDENTITY,
                projection: Projection::Perspective { y_fov: 1.0 },
                aperture_radius: 0.0,
                aperture_blades: 0,
                aperture_rotation: 0.0,
                focus_distance: 1.0,
            })
            .collect();
        Scene {
            cameras,
            ..Scene::default()
        }
    }

    fn found(names: &[&str], wanted: &str) -> Result<String, String> {
        match find_camera(&scene(names), wanted) {
            Ok(camera) => Ok(camera.name),
            Err(Failure::Failed(text)) => Err(text),
            Err(other) => panic!("a camera is not a usage error: {other:?}"),
        }
    }

    #[test]
    fn a_camera_is_found_by_name_then_by_number() {
        assert_eq!(found(&["1", "Door"], "1").as_deref(), Ok("1"));
        assert_eq!(found(&["Door", "Bed"], "1").as_deref(), Ok("Bed"));
    }

    #[test]
    fn an_unknown_camera_is_answered_with_the_names() {
        let error = found(&["Door", "Bed"], "Roof").unwrap_err();
        assert!(error.contains("'Door', 'Bed'"), "{error}");
        let error = found(&[], "Roof").unwrap_err();
        assert!(error.contains("no cameras"), "{error}");
    }
}
