//! `patina bench render`: whole renders of several scenes in turn, as a table and as JSON.

use device::Device;
use engine::renderer::RenderSettings;
use patina_bench::render::{self as bench, Effort, Workload};
use patina_bench::report::renders::RenderFigures;
use patina_bench::scenes;

use crate::failure::Failure;
use crate::progress::Bar;
use crate::{console, interrupt};

use super::job::{Amount, RenderJob};
use super::prepared::Prepared;
use super::report;

/// What is rendered if the user says nothing.
const USUAL: Amount = Amount {
    width: 512,
    height: 512,
    spp: 16,
    runs: 3,
};

/// Measures, prints a table for each scene and writes the figures.
///
/// # Errors
/// A scene or look that can't be loaded or rendered, no device, a file that can't be written.
pub(super) fn run(job: &RenderJob) -> Result<(), Failure> {
    let written: Vec<_> = job.effort.json.iter().cloned().collect();
    let scenes: Vec<_> = job.scenes.iter().collect();
    report::check(
        &written,
        &scenes,
        job.look.as_deref(),
        &job.effort.texture_dirs,
    )?;
    let bar = Bar::new("loading the scenes");
    let prepared = prepare(job, &bar)?;
    bar.stage("measuring");
    let device = Device::open(&job.effort.device).map_err(Failure::because)?;
    bar.follow(&device);
    let mut amount = job.effort.amount(USUAL);
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
    let effort = Effort {
        spp: amount.spp,
        runs: amount.runs,
        is_over: interrupt::requested,
    };
    let rendered = bench::render(&device, &workloads, effort, |runs| {
        if runs > 0 {
            interrupt::has_results();
        }
        bar.step();
    });
    let (scenes, runs) = rendered.map_err(Failure::because)?;
    interrupt::writes_results();
    // Fewer where it was interrupted.
    amount.runs = runs;
    bar.finish();

    let report = RenderFigures {
        conditions: report::conditions(&job.effort, amount, &device),
        scenes,
    };
    console::print(&report.table());
    report::write(&job.effort, &report)?;
    match interrupt::requested() {
        true => Err(Failure::Interrupted),
        false => Ok(()),
    }
}

fn prepare(job: &RenderJob, bar: &Bar) -> Result<Vec<Prepared>, Failure> {
    if job.scenes.is_empty() {
        return Ok(vec![
            Prepared::built_in("tunnel", scenes::tunnel())?,
            Prepared::cornell_box()?,
        ]);
    }
    let scenes = job
        .scenes
        .iter()
        .map(|path| Prepared::load(path, job.look.as_deref(), &job.effort.texture_dirs, bar));
    scenes.collect()
}
