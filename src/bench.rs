//! `patina bench`: how fast parts of the renderer are on this machine.

pub(crate) mod args;
mod edit;
pub(crate) mod job;
mod kernel;
mod render;
mod report;
mod textures;

use device::Device;
use engine::bench::scenes;
use engine::scene::{self, Scene};
use engine::{bench, load};

use crate::exit::Failure;
use crate::progress::Bar;
use crate::{console, devices};

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
        } => edit::run(*nodes, *edits, device),
        BenchJob::Render(job) => render::run(job),
        BenchJob::Textures(job) => textures::run(job),
        BenchJob::Traverse(job) => traverse(job),
    }
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
    let gpu = Device::open(&job.device).map_err(Failure::because)?;
    bar.follow(&gpu);
    let report = bench::traverse(&gpu, &scene).map_err(Failure::because)?;
    bar.finish();

    console::print(&format!(
        "{name}: {} triangles\n{}\n\n\
         primary rays   {:8.2} Mrays/s\n\
         bounce rays    {:8.2} Mrays/s\n\
         shadow rays    {:8.2} Mrays/s",
        console::grouped(scene.instanced_triangles()),
        devices::title(gpu.description()),
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
