//! `patina bench textures`: what rust and scratches cost over plain grey, for each form of the texture kernel, and what
//! changes that cost. From a job to measurements to a table and to report files.

use std::io::Write as _;

use device::{Device, DeviceChoice, DeviceError, DeviceOptions};
use engine::load;
use engine::procedural::TextureSources;
use engine::renderer::RenderSettings;
use engine::scene::{Camera, Scene, default_camera};
use patina_bench::forms::Form;
use patina_bench::report::figures::Figures;
use patina_bench::report::{charts, page, paper};
use patina_bench::scenes::{self, MODEL};
use patina_bench::textures::{self as bench, Absent, Setup};
use patina_bench::{coverage, insert, sweeps};

use crate::failure::Failure;
use crate::output;
use crate::progress::Bar;
use crate::{console, interrupt, library};

use super::job::{Amount, Model, ReportFormat, TexturesJob};
use super::report;

/// What is rendered if the user says nothing: some minutes on two cores of a server, by a driver in software.
const USUAL_ON_CPU: Amount = Amount {
    width: 256,
    height: 256,
    spp: 4,
    runs: 5,
};
/// The same by the native device, which is faster.
const USUAL_NATIVE: Amount = Amount {
    spp: 16,
    ..USUAL_ON_CPU
};
/// Enough to keep a GPU busy.
const USUAL_ON_GPU: Amount = Amount {
    width: 1280,
    height: 720,
    spp: 32,
    runs: 9,
};

/// What is rendered.
struct Prepared {
    name: String,
    scene: Scene,
    material: String,
    camera: Camera,
}

/// Measures, prints a table for each number of AO rays and each sweep, and writes the reports, anew after each sweep. A sweep that
/// fails is told of in them, and in the end.
///
/// # Errors
/// A scene or look that can't be loaded, textures that are missing, no device, pictures that differ between the forms, a sweep
/// that failed, a file that can't be written.
pub(super) fn run(job: &TexturesJob) -> Result<(), Failure> {
    let reports = job.reports.iter().map(|report| &report.path);
    let written: Vec<_> = reports.chain(&job.effort.json).cloned().collect();
    let scenes: Vec<_> = match &job.scene {
        Some((scene, Model::Inserted(model))) => vec![scene, model],
        Some((scene, Model::Material(_))) => vec![scene],
        None => Vec::new(),
    };
    report::check(
        &written,
        &scenes,
        job.look.as_deref(),
        &job.effort.texture_dirs,
    )?;
    let bar = Bar::new("loading the scene");
    let folders = library::texture_dirs(&job.effort.texture_dirs, None)?;
    let sources = TextureSources::search(&folders).map_err(Failure::because)?;
    let prepared = prepare(job, &folders, &bar)?;
    let (device, forms, left_out) = open(job)?;
    bar.follow(&device);
    let usual = match device.traits() {
        traits if traits.compiles_slowly => USUAL_ON_CPU,
        traits if traits.runs_threads_in_turn => USUAL_NATIVE,
        _ => USUAL_ON_GPU,
    };
    let amount = job.effort.amount(usual);
    let setup = Setup {
        scene: &prepared.scene,
        material: &prepared.material,
        sources: &sources,
        settings: RenderSettings {
            max_depth: job.effort.max_depth,
            ..RenderSettings::new(amount.width, amount.height, &prepared.camera)
        },
        spp: amount.spp,
        runs: amount.runs,
        ao_rays: &job.ao_rays,
        forms: &forms,
        statistics_device: job.statistics_device.as_deref(),
        is_over: interrupt::requested,
    };
    bar.stage("measuring");
    let of_sweeps = job.sweeps.iter().map(|&what| sweeps::steps(&setup, what));
    bar.count(bench::steps(&setup) + of_sweeps.sum::<u64>());
    let compared = bench::compare(&device, &setup, || bar.step()).map_err(Failure::because)?;
    let share = coverage::measure(&device, setup.scene, setup.material, &setup.settings);
    let coverage = share.map_err(Failure::because)?;
    let mut figures = Figures {
        conditions: report::conditions(&job.effort, amount, &device),
        triangles: prepared.scene.instanced_triangles(),
        scene: prepared.name,
        material: prepared.material.clone(),
        coverage,
        results: compared.results,
        absent: compared.absent.into_iter().chain(left_out).collect(),
        statistics_device: compared.statistics_device,
        statistics_absent: compared.statistics_absent,
        sweeps: Vec::new(),
        paper: &paper::TABLE,
    };
    // All that is finished is written before a sweep begins: a driver that compiles for its kernels isn't waited for after a signal.
    interrupt::writes_results();
    bar.suspend(|| console::print(&figures.table()));
    write(job, &figures)?;
    for &what in &job.sweeps {
        interrupt::goes_on();
        bar.stage(what.name());
        let swept = sweeps::sweep(&device, &setup, what, || bar.step());
        interrupt::writes_results();
        bar.suspend(|| console::print(&swept.table()));
        figures.sweeps.push(swept);
        write(job, &figures)?;
    }
    bar.finish();
    for report in &job.reports {
        console::note(&format!("wrote {}", report.path.display()));
    }
    if interrupt::requested() {
        return Err(Failure::Interrupted);
    }
    let mut failed = figures.sweeps.iter().filter_map(|sweep| {
        let reason = sweep.ended.as_ref()?;
        Some(format!("the sweep `{}`: {reason}", sweep.sweep))
    });
    match failed.next() {
        Some(failed) => Err(Failure::Failed(failed)),
        None => Ok(()),
    }
}

/// Writes what there is.
///
/// # Errors
/// A file that can't be written, a chart or a picture that can't be made.
fn write(job: &TexturesJob, figures: &Figures) -> Result<(), Failure> {
    report::write(&job.effort, figures)?;
    for report in &job.reports {
        let text = match report.format {
            ReportFormat::Html => page::html(figures).map_err(Failure::because)?,
            ReportFormat::Json => figures.json().map_err(Failure::because)?,
            ReportFormat::Svg => charts::increases(figures).map_err(Failure::because)?,
        };
        output::write_aside(&report.path, |file| file.write_all(text.as_bytes()))
            .map_err(Failure::because)?;
    }
    Ok(())
}

/// Opens the device. If no forms were named they are all of them, but on a software driver not the one that such drivers
/// compile for minutes; that it is left out is said.
fn open(job: &TexturesJob) -> Result<(Device, Vec<Form>, Option<Absent>), Failure> {
    let choice = &job.effort.device;
    let open = |forms: &[Form]| {
        let opened = match forms.contains(&Form::RayQuery) {
            true => Device::open_with(&DeviceOptions::new(choice).with_ray_queries()),
            false => Device::open(choice),
        };
        match opened {
            // Asking for ray queries asks for a driver, which there is none of: other forms do without.
            Err(DeviceError::NotFound { .. }) if *choice == DeviceChoice::Best => {
                Device::open(choice)
            }
            opened => opened,
        }
        .map_err(Failure::because)
    };
    if let Some(forms) = &job.forms {
        let device = open(forms)?;
        if forms[..] == [Form::RayQuery] && !device.has_ray_queries() {
            let name = &device.description().name;
            return Err(Failure::Failed(format!(
                "no device with ray queries, which `--modes rayquery` needs: {name} has none; `patina devices` says which have them"
            )));
        }
        return Ok((device, forms.clone(), None));
    }
    let few = vec![Form::Stack, Form::Inlined];
    let usual = open(&few)?;
    if usual.gpu().is_none() {
        let absent = Absent {
            mode: Form::RayQuery.name(),
            reason: "the device has no ray queries".to_owned(),
        };
        return Ok((usual, few, Some(absent)));
    }
    drop(usual);
    let all = Form::ALL.to_vec();
    let device = open(&all)?;
    if !device.traits().compiles_slowly {
        return Ok((device, all, None));
    }
    let absent = Absent {
        mode: Form::RayQuery.name(),
        reason: match device.has_ray_queries() {
            true => "a software driver compiles its kernels for minutes; `--modes rayquery` measures it nevertheless",
            false => "the device has no ray queries",
        }
        .to_owned(),
    };
    Ok((open(&few)?, few, Some(absent)))
}

/// Loads the scene, or builds it, and finds what is to be textured.
fn prepare(
    job: &TexturesJob,
    folders: &[std::path::PathBuf],
    bar: &Bar,
) -> Result<Prepared, Failure> {
    let Some((path, model)) = &job.scene else {
        let scene = scenes::arcade();
        let camera = scene.cameras.first().cloned();
        return Ok(Prepared {
            name: "arcade".to_owned(),
            camera: camera.unwrap_or_else(|| default_camera(&scene)),
            material: MODEL.to_owned(),
            scene,
        });
    };
    let mut loaded = load::load(path, job.look.as_deref(), folders)?;
    bar.suspend(|| console::diagnostics(&loaded.warnings));
    let name = path.display().to_string();
    Ok(match model {
        Model::Material(material) => Prepared {
            name,
            material: material.clone(),
            scene: loaded.scene,
            camera: loaded.camera,
        },
        Model::Inserted(model) => {
            let chosen = job.look.is_some() || !loaded.scene.cameras.is_empty();
            let camera = chosen.then_some(loaded.camera);
            let inserted = insert::model(&mut loaded.scene, camera, model);
            let inserted = inserted.map_err(Failure::because)?;
            bar.suspend(|| {
                for warning in &inserted.warnings {
                    console::warning(warning);
                }
            });
            Prepared {
                name: format!("{name} with {}", model.display()),
                material: inserted.material,
                scene: loaded.scene,
                camera: inserted.camera,
            }
        }
    })
}
