//! `patina bench methods`: how long ways to render a picture take until it is good enough, as a table and report files.

use std::io::Write as _;
use std::path::Path;
use std::time::Duration;

use device::Device;
use engine::input;
use engine::renderer::RenderSettings;
use patina_bench::methods::{self as bench, How, Setup};
use patina_bench::report::methods::MethodsFigures;
use pictures::Facts;

use crate::failure::Failure;
use crate::progress::Bar;
use crate::{console, interrupt, output, picture};

use super::job::{Amount, MethodsJob, ReportFormat};
use super::prepared::Prepared;
use super::report;

/// What is rendered if the user says nothing; the samples are the most of each picture.
const USUAL: Amount = Amount {
    width: 256,
    height: 256,
    spp: 1024,
    runs: 1,
};

/// Formats of linear light, as [`Facts`] calls them.
const LINEAR: [&str; 2] = ["OpenEXR", "Radiance HDR"];

/// The most samples on a GPU, which takes no longer for them.
const ON_A_GPU: u32 = 16_384;

/// Measures, prints the table and writes the reports.
///
/// # Errors
/// A scene, a look or a reference that can't be loaded or rendered, no device, a file that can't be written.
pub(super) fn run(job: &MethodsJob) -> Result<(), Failure> {
    let written: Vec<_> = job
        .reports
        .iter()
        .map(|report| report.path.clone())
        .chain(job.effort.json.clone())
        .collect();
    let read: Vec<_> = job.scene.iter().collect();
    report::check(
        &written,
        &read,
        job.look.as_deref(),
        &job.effort.texture_dirs,
    )?;
    let compared: Vec<_> = job.reference.iter().cloned().collect();
    output::check_all(&written, &compared)?;
    let bar = Bar::new("loading the scene");
    let prepared = Prepared::load_or_cornell_box(
        job.scene.as_deref(),
        job.look.as_deref(),
        &job.effort.texture_dirs,
        &bar,
    )?;
    let reference = job.reference.as_deref().map(reference).transpose()?;
    let device = Device::open(&job.effort.device).map_err(Failure::because)?;
    bar.follow(&device);
    let amount = job.effort.amount(Amount {
        spp: match device.traits().shares_the_processor {
            true => USUAL.spp,
            false => ON_A_GPU,
        },
        ..USUAL
    });
    let setup = Setup {
        scene: &prepared.scene,
        procedural: &prepared.procedural,
        settings: RenderSettings {
            max_depth: job.effort.max_depth,
            ..RenderSettings::new(amount.width, amount.height, &prepared.camera)
        },
        methods: match job.methods.is_empty() {
            true => How::ALL.to_vec(),
            false => job.methods.clone(),
        },
        reference,
        reference_spp: job.reference_spp,
        most_spp: amount.spp,
        runs: amount.runs,
        exposure: job.exposure,
        limit: Duration::from_secs(60 * u64::from(job.minutes)),
        is_over: interrupt::requested,
    };
    let measured = bench::measure(&device, &setup, |case| {
        if case != bench::REFERENCE {
            interrupt::has_results();
        }
        bar.stage(&format!("measuring: {case}"));
    });
    let measured = measured.map_err(Failure::because)?;
    interrupt::writes_results();
    bar.finish();
    if interrupt::requested() && !measured.has_figures() {
        // What an earlier measurement wrote is worth more.
        console::warning(interrupt::NOTHING);
        return Err(Failure::Interrupted);
    }

    let figures = MethodsFigures {
        conditions: report::conditions(&job.effort, amount, &device),
        scene: prepared.name,
        triangles: prepared.scene.instanced_triangles(),
        exposure: job.exposure,
        report: measured,
    };
    console::print(&figures.table());
    report::write(&job.effort, &figures)?;
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

/// The format of a picture whose numbers are codes of a screen; `None` of linear ones.
///
/// # Errors
/// It can't be read.
fn encoded(path: &Path) -> Result<Option<String>, Failure> {
    if picture::is_film(path)? {
        return Ok(None);
    }
    let bytes = input::read(path, picture::MAX_FILE);
    let facts = Facts::read(&bytes.map_err(|error| picture::unread(path, error))?);
    let format = facts.map_err(Failure::because)?.format;
    Ok((!LINEAR.contains(&format.as_str())).then_some(format))
}

/// A converged picture of linear light: columns and rows, and colours.
///
/// # Errors
/// It can't be read, has no colours, or other ones.
fn reference(path: &Path) -> Result<([usize; 2], Vec<[f32; 3]>), Failure> {
    let layer = picture::layer(path, None)?;
    if let Some(format) = encoded(path)? {
        let path = path.display();
        return Err(Failure::Failed(format!(
            "{path}: {format} files hold what a screen shows, rounded and cut off at white; --reference takes a picture of linear light: \
             .exr, .hdr or .patina-film"
        )));
    }
    let [Some(red), Some(green), Some(blue)] = [0, 1, 2].map(|at| layer.channels.get(at)) else {
        let path = path.display();
        return Err(Failure::Failed(format!("{path}: it has no colours")));
    };
    let pixels = red.values.iter().zip(&green.values).zip(&blue.values);
    let colours = pixels.map(|((&r, &g), &b)| [r, g, b]).collect();
    Ok((layer.size, colours))
}
