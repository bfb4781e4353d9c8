//! `patina bench textures`: what rust and scratches cost over plain gray, for each form of the texture kernel.

use std::fmt::Write as _;
use std::io::Write as _;

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
use crate::report::Device;
use crate::{console, library, output};

use super::job::TexturesJob;

/// All rows. The JSON form is read by other programs: fields are added, never renamed.
#[derive(Debug, Serialize)]
struct Report {
    /// Version of this program.
    patina: &'static str,
    device: Device,
    scene: String,
    triangles: u64,
    /// Pixels.
    width: u32,
    /// Pixels.
    height: u32,
    samples_per_pixel: u32,
    max_depth: u32,
    /// Timed runs of each case, in turn.
    runs: u32,
    results: Vec<TextureResult>,
}

/// Measures, prints a table for each number of AO rays and writes the figures.
///
/// # Errors
/// A scene or look that can't be loaded, textures that are missing, no device, pictures that differ between the forms,
/// a file that can't be written.
pub(super) fn run(job: &TexturesJob) -> Result<(), Failure> {
    if let Some(path) = &job.json {
        output::check(path).map_err(Failure::because)?;
    }
    let bar = Bar::new("loading the scene");
    let folders = library::texture_dirs(&job.texture_dirs, None)?;
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
    let gpu = Gpu::new(&job.device).map_err(Failure::because)?;
    bar.stage("measuring");
    let mut results = Vec::new();
    for &ao_rays in &job.ao_rays {
        let setup = Setup {
            scene: &scene,
            material,
            sources: &sources,
            settings: RenderSettings {
                max_depth: job.max_depth,
                ..RenderSettings::new(job.width, job.height, &camera)
            },
            spp: job.spp,
            runs: job.runs,
            ao_rays,
            forms: &job.forms,
        };
        results.extend(bench::compare(&gpu, &setup, || ()).map_err(Failure::because)?);
    }
    bar.finish();
    let report = Report {
        patina: env!("CARGO_PKG_VERSION"),
        device: Device::new(gpu.description()),
        scene: name,
        triangles: scene.instanced_triangles(),
        width: job.width,
        height: job.height,
        samples_per_pixel: job.spp,
        max_depth: job.max_depth,
        runs: job.runs,
        results,
    };
    console::print(&report.table());
    if let Some(path) = &job.json {
        output::write_aside(path, |file| {
            serde_json::to_writer_pretty(&mut *file, &report)?;
            file.write_all(b"\n")
        })
        .map_err(Failure::because)?;
    }
    Ok(())
}

impl Report {
    fn table(&self) -> String {
        let mut text = format!(
            "{}\n{}: {} triangles, {}x{}, {} samples per pixel, depth {}; medians of {} runs in turn (lowest to highest)\n",
            self.device.title,
            self.scene,
            console::grouped(self.triangles),
            self.width,
            self.height,
            self.samples_per_pixel,
            self.max_depth,
            self.runs
        );
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
