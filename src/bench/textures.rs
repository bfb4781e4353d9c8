//! `patina bench textures`: what rust and scratches cost over plain gray, for each form of the texture kernel.

use std::fmt::Write as _;

use engine::bench::forms::Form;
use engine::bench::inspect::Inspection;
use engine::bench::textures::{self as bench, MODEL, Setup, TextureResult};
use engine::bench::{render::Spread, scenes};
use engine::gpu::Gpu;
use engine::load;
use engine::procedural::TextureSources;
use engine::renderer::RenderSettings;
use engine::scene::default_camera;
use serde::Serialize;

use crate::exit::Failure;
use crate::progress::Bar;
use crate::{console, library};

use super::job::TexturesJob;
use super::report::{self, Conditions};

/// All rows. The JSON form is read by other programs: fields are added, never renamed.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    conditions: Conditions,
    scene: String,
    triangles: u64,
    /// Whose driver told registers and stack.
    statistics_device: Option<String>,
    /// Why nothing is known of them, if that is so.
    statistics_absent: Option<String>,
    results: Vec<TextureResult>,
}

/// Measures, prints a table for each number of AO rays and writes the figures.
///
/// # Errors
/// A scene or look that can't be loaded, textures that are missing, no device, pictures that differ between the forms,
/// a file that can't be written.
pub(super) fn run(job: &TexturesJob) -> Result<(), Failure> {
    report::check(&job.effort)?;
    let bar = Bar::new("loading the scene");
    let folders = library::texture_dirs(&job.effort.texture_dirs, None)?;
    let sources = TextureSources::scan(&folders).map_err(Failure::because)?;
    let (name, material, scene, camera) = match &job.scene {
        None => {
            let scene = scenes::arcade();
            let camera = default_camera(&scene);
            let camera = scene.cameras.first().cloned().unwrap_or(camera);
            ("arcade".to_owned(), MODEL, scene, camera)
        }
        Some((path, material)) => {
            let loaded = load::load(path, job.look.as_deref(), &folders)?;
            bar.suspend(|| console::diagnostics(&loaded.warnings));
            let name = path.display().to_string();
            (name, material.as_str(), loaded.scene, loaded.camera)
        }
    };
    let gpu = match job.forms.contains(&Form::RayQuery) {
        true => Gpu::with_ray_queries(&job.effort.device),
        false => Gpu::new(&job.effort.device),
    };
    let gpu = gpu.map_err(Failure::because)?;
    bar.stage("measuring");
    let mut results = Vec::new();
    for &ao_rays in &job.ao_rays {
        let setup = Setup {
            scene: &scene,
            material,
            sources: &sources,
            settings: RenderSettings {
                max_depth: job.effort.max_depth,
                ..RenderSettings::new(job.effort.width, job.effort.height, &camera)
            },
            spp: job.effort.spp,
            runs: job.effort.runs,
            ao_rays,
            forms: &job.forms,
            statistics_device: job.statistics_device.as_deref(),
        };
        results.extend(bench::compare(&gpu, &setup, || ()).map_err(Failure::because)?);
    }
    bar.finish();
    let inspection = Inspection::new(&gpu, job.statistics_device.as_deref());
    let report = Report {
        conditions: Conditions::new(&job.effort, &gpu),
        scene: name,
        triangles: scene.instanced_triangles(),
        statistics_device: inspection.device().map(str::to_owned),
        statistics_absent: inspection.absent().map(str::to_owned),
        results,
    };
    console::print(&report.table());
    report::write(&job.effort, &report)
}

impl Report {
    fn table(&self) -> String {
        let mut text = self.conditions.text();
        let _ = writeln!(
            text,
            "{}: {} triangles",
            self.scene,
            console::grouped(self.triangles)
        );
        if let Some(reason) = &self.statistics_absent {
            let _ = writeln!(text, "registers and stack are not known: {reason}");
        }
        if let Some(device) = &self.statistics_device {
            let _ = writeln!(text, "registers and stack on {device}:");
        }
        for row in self.results.iter().filter(|row| row.registers.is_some()) {
            let figure = |known: Option<f64>| known.map_or("-".to_owned(), |v| v.to_string());
            let _ = writeln!(
                text,
                "  {} {}, {} AO rays: {} registers, {} bytes of stack, {} spills",
                row.mode,
                row.texture,
                row.ao_rays,
                figure(row.registers),
                figure(row.stack_bytes),
                figure(row.spills)
            );
        }
        let mut ao_rays = 0;
        for row in &self.results {
            if row.ao_rays != ao_rays {
                ao_rays = row.ao_rays;
                let _ = writeln!(
                    text,
                    "\n{ao_rays} AO rays\n{:<9}{:<11}{:>10}  {:<28}{:>8}{:>10}{:>11}{:>12}{:>11}",
                    "form",
                    "texture",
                    "ms/spp",
                    "over gray",
                    "bytes",
                    "edit, ms",
                    " pipelines",
                    " source, ms",
                    " known, ms"
                );
            }
            write_row(&mut text, row);
        }
        text
    }
}

fn write_row(text: &mut String, row: &TextureResult) {
    let Spread { median, low, high } = row.increase_percent;
    let increase = match row.texture {
        "gray" => String::new(),
        _ => format!("{median:+.1} % ({low:+.1} to {high:+.1})"),
    };
    let _ = writeln!(
        text,
        "{:<9}{:<11}{:>10.1}  {increase:<28}{:>8}{:>10.1}{:>11}{:>12.0}{:>11.0}",
        row.mode,
        row.texture,
        row.ms_per_spp.median,
        row.private_bytes,
        row.edit_ms,
        row.pipelines_created,
        row.source_edit_ms,
        row.build_ms_warm
    );
}
