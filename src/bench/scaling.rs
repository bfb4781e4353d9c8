//! `patina bench scaling`: how rendering scales with threads, sizes of pieces, and devices, as tables and report files.

use std::io::Write as _;
use std::sync::Arc;
use std::time::Duration;

use device::{Device, DeviceChoice};
use engine::stats::DeviceFacts;
use patina_bench::report::conditions;
use patina_bench::report::scaling::ScalingFigures;
use patina_bench::scaling::{self as bench, Setup};

use crate::failure::Failure;
use crate::progress::Bar;
use crate::{console, devices, interrupt, output};

use super::job::{ReportFormat, ScalingJob};
use super::prepared::Prepared;
use super::report;

/// Measures, prints the tables and writes the reports.
///
/// # Errors
/// A scene or look that can't be loaded or rendered, a device that isn't there, a file that can't be written.
pub(super) fn run(job: &ScalingJob) -> Result<(), Failure> {
    let written: Vec<_> = job
        .reports
        .iter()
        .map(|report| report.path.clone())
        .collect();
    let scenes: Vec<_> = job.scene.iter().collect();
    report::check(&written, &scenes, job.look.as_deref(), &job.texture_dirs)?;
    let together = devices::choices(&job.devices);
    // One that isn't there is found before anything is measured.
    for choice in &together {
        Device::open(choice).map(drop).map_err(Failure::because)?;
    }
    let bar = Bar::new("loading the scene");
    let prepared = Prepared::load_or_cornell_box(
        job.scene.as_deref(),
        job.look.as_deref(),
        &job.texture_dirs,
        &bar,
    )?;
    let threads = job.threads.clone().unwrap_or_else(usual_threads);
    let most = threads.last().copied().unwrap_or(1);
    let setup = Setup {
        scene: Arc::new(prepared.scene),
        procedural: Arc::new(prepared.procedural),
        camera: prepared.camera,
        max_depth: job.max_depth,
        spp: job.spp,
        sides: job.sides.clone(),
        tiles: job.tiles.clone(),
        devices: match together.is_empty() {
            true => vec![DeviceChoice::Native(1); most as usize],
            false => together,
        },
        threads,
        runs: job.runs,
        limit: Duration::from_secs(60 * u64::from(job.minutes)),
        is_over: interrupt::requested,
    };
    let processor = Device::open(&DeviceChoice::Native(most)).map_err(Failure::because)?;
    let measured = bench::measure(&setup, |case, report| {
        if report.has_figures() {
            interrupt::has_results();
        }
        bar.stage(&format!("measuring: {case}"));
    });
    let measured = measured.map_err(Failure::because)?;
    interrupt::writes_results();
    bar.finish();

    let figures = ScalingFigures {
        patina: env!("CARGO_PKG_VERSION"),
        commit: env!("PATINA_COMMIT"),
        date: conditions::date(),
        device: DeviceFacts::new(processor.description()),
        scene: prepared.name,
        triangles: setup.scene.instanced_triangles(),
        samples_per_pixel: job.spp,
        max_depth: job.max_depth,
        runs: job.runs,
        report: measured,
    };
    console::print(&figures.table());
    for report in &job.reports {
        let text = match report.format {
            ReportFormat::Html => figures.html().map_err(Failure::because)?,
            ReportFormat::Json => figures.json().map_err(Failure::because)?,
            ReportFormat::Svg => figures.svg().map_err(Failure::because)?,
        };
        output::write_aside(&report.path, |file| file.write_all(text.as_bytes()))
            .map_err(Failure::because)?;
        console::note(&format!("wrote {}", report.path.display()));
    }
    match interrupt::requested() {
        true => Err(Failure::Interrupted),
        false => Ok(()),
    }
}

/// 1, 2, 4 and so on, and as many as there are.
fn usual_threads() -> Vec<u32> {
    let most = std::thread::available_parallelism().map_or(1, |count| count.get() as u32);
    let powers = std::iter::successors(Some(1), |count: &u32| Some(2 * count));
    powers
        .take_while(|&count| count < most)
        .chain([most])
        .collect()
}
