//! `patina bench render`: whole renders of several scenes in turn, as a table and as JSON.

use std::path::Path;

use device::Device;
use engine::load;
use engine::procedural::{Procedural, TextureSources};
use engine::renderer::RenderSettings;
use engine::scene::look::{Look, LookError};
use engine::scene::{Camera, Scene, default_camera};
use patina_bench::render::{self as bench, Workload};
use patina_bench::report::renders::RenderFigures;
use patina_bench::scenes;

use crate::failure::Failure;
use crate::progress::Bar;
use crate::{console, library};

use super::job::{Amount, RenderJob};
use super::report;

/// What is rendered if the user says nothing.
const USUAL: Amount = Amount {
    width: 512,
    height: 512,
    spp: 16,
    runs: 3,
};

/// Something to be rendered.
struct Prepared {
    name: String,
    scene: Scene,
    procedural: Procedural,
    camera: Camera,
}

impl Prepared {
    /// A built-in scene, seen by its first camera.
    fn built_in(name: &str, mut scene: Scene) -> Result<Self, Failure> {
        let nothing = Look::parse(Path::new(""), "")?;
        let procedural = Procedural::build(&nothing, &mut scene, &TextureSources::default())
            .map_err(LookError::from)?;
        let camera = scene.cameras.first().cloned();
        let camera = camera.unwrap_or_else(|| default_camera(&scene));
        Ok(Self {
            name: name.to_owned(),
            camera,
            procedural,
            scene,
        })
    }
}

/// Measures, prints a table for each scene and writes the figures.
///
/// # Errors
/// A scene or look that can't be loaded or rendered, no device, a file that can't be written.
pub(super) fn run(job: &RenderJob) -> Result<(), Failure> {
    let written: Vec<_> = job.effort.json.iter().cloned().collect();
    let scenes: Vec<_> = job.scenes.iter().collect();
    report::check(&written, &scenes, job.look.as_deref())?;
    let bar = Bar::new("loading the scenes");
    let prepared = prepare(job, &bar)?;
    bar.stage("measuring");
    let device = Device::open(&job.effort.device).map_err(Failure::because)?;
    bar.follow(&device);
    let amount = job.effort.amount(USUAL);
    let workloads: Vec<Workload<'_>> = prepared
        .iter()
        .map(|prepared| Workload {
            name: prepared.name.clone(),
            scene: &prepared.scene,
            procedural: &prepared.procedural,
            settings: RenderSettings {
                max_depth: job.effort.max_depth,
                ..RenderSettings::new(amount.width, amount.height, &prepared.camera)
            },
        })
        .collect();
    bar.count(workloads.len() as u64 * (u64::from(amount.runs) + 1));
    let scenes = bench::render(&device, &workloads, amount.spp, amount.runs, |_| bar.step())
        .map_err(Failure::because)?;
    bar.finish();

    let report = RenderFigures {
        conditions: report::conditions(&job.effort, amount, &device),
        scenes,
    };
    console::print(&report.table());
    report::write(&job.effort, &report)
}

fn prepare(job: &RenderJob, bar: &Bar) -> Result<Vec<Prepared>, Failure> {
    if job.scenes.is_empty() {
        return Ok(vec![
            Prepared::built_in("tunnel", scenes::tunnel())?,
            Prepared::built_in("Cornell box", scenes::cornell_box())?,
        ]);
    }
    let texture_dirs = library::texture_dirs(&job.effort.texture_dirs, job.look.as_deref())?;
    let mut prepared = Vec::new();
    for path in &job.scenes {
        let loaded = load::load(path, job.look.as_deref(), &texture_dirs)?;
        bar.suspend(|| console::diagnostics(&loaded.warnings));
        prepared.push(Prepared {
            name: path.display().to_string(),
            scene: loaded.scene,
            procedural: loaded.procedural,
            camera: loaded.camera,
        });
    }
    Ok(prepared)
}
