//! `patina bench`: how fast parts of the renderer are on this machine.

pub(crate) mod args;
pub(crate) mod job;
mod kernel;
mod methods;
mod prepared;
mod render;
mod report;
mod scaling;
mod textures;

use device::{Device, DeviceChoice};
use engine::load;
use engine::scene::{self, Scene};
use patina_bench::edit::{self, EditBenchError};
use patina_bench::{gather, scenes, traverse as rays};

use crate::console;
use crate::failure::Failure;
use crate::progress::Bar;

use self::job::{BenchJob, TraverseJob};

/// Measures what is asked for.
///
/// # Errors
/// Those of the measurement.
pub(crate) fn run(job: &BenchJob) -> Result<(), Failure> {
    match job {
        BenchJob::Kernel {
            most,
            texture_dirs,
            device,
        } => kernel::run(*most as usize, texture_dirs, device),
        BenchJob::Edit {
            nodes,
            edits,
            device,
        } => edits_of_a_look(*nodes, *edits, device),
        BenchJob::Gather {
            photons,
            runs,
            device,
        } => gather(*photons, *runs, device),
        BenchJob::Methods(job) => methods::run(job),
        BenchJob::Render(job) => render::run(job),
        BenchJob::Scaling(job) => scaling::run(job),
        BenchJob::Textures(job) => textures::run(job),
        BenchJob::Traverse(job) => traverse(job),
    }
}

/// Measures live edits and prints their times.
///
/// # Errors
/// There is no device, or no room for the scene among the temporary files.
fn edits_of_a_look(nodes: u32, edits: u32, device: &DeviceChoice) -> Result<(), Failure> {
    let bar = Bar::new("preparing the look");
    let report = edit::measure(nodes, edits, device, || bar.stage("measuring"));
    let report = report.map_err(|error| match error {
        EditBenchError::Files(error) => Failure::because(error),
        EditBenchError::Session(error) => error.into(),
    })?;
    bar.finish();
    console::print(&report.table());
    Ok(())
}

/// Measures ways to find photons and prints their times.
///
/// # Errors
/// There is no device, or no room on it.
fn gather(photons: u32, runs: u32, device: &DeviceChoice) -> Result<(), Failure> {
    let bar = Bar::new("preparing the device");
    let device = Device::open(device).map_err(Failure::because)?;
    bar.follow(&device);
    let report = gather::measure(&device, photons, runs, |case| {
        bar.stage(&format!("measuring: {case}"));
    });
    let report = report.map_err(Failure::because)?;
    bar.finish();
    console::print(&report.table());
    Ok(())
}

/// Measures the traversal kernel and prints millions of rays per second.
///
/// # Errors
/// The scene cannot be loaded or there is no device.
fn traverse(job: &TraverseJob) -> Result<(), Failure> {
    let bar = Bar::new("loading the scene");
    let (name, scene) = match &job.scene {
        Some(path) => {
            let loaded = load::load(path, None, &[]).map_err(Failure::because)?;
            (path.display().to_string(), with_camera(loaded.scene))
        }
        None => ("built-in scene".to_owned(), scenes::tunnel()),
    };
    bar.stage("measuring");
    let device = Device::open(&job.device).map_err(Failure::because)?;
    bar.follow(&device);
    let report = rays::traverse(&device, &scene).map_err(Failure::because)?;
    bar.finish();

    console::print(&format!(
        "{name}: {} triangles\n{}\n\n\
         primary rays   {:8.2} Mrays/s\n\
         bounce rays    {:8.2} Mrays/s\n\
         shadow rays    {:8.2} Mrays/s",
        console::grouped(scene.instanced_triangles()),
        device.description().title(),
        report.primary,
        report.bounce,
        report.shadow
    ));
    Ok(())
}

fn with_camera(mut scene: Scene) -> Scene {
    if scene.cameras.is_empty() {
        scene.cameras = vec![scene::default_camera(&scene)];
    }
    scene
}
