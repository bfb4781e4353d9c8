//! What `--stats` prints and `--stats-json` writes: time and share of each pass, rates, memory.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use engine::film::Tally;
use engine::fleet::DeviceShare;
use engine::renderer::TextureCosts;
use engine::stats::{DeviceFacts, Stats};
use serde::Serialize;

use crate::console;
use crate::job::{Limits, RenderJob};
use crate::output::{self, OutputError};
use crate::words::MAX_SPP;

/// Textures that the table lists.
const EXPENSIVE: usize = 12;

/// Figures of one render. Its JSON form is read by other programs: fields are added, never renamed.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    /// Version of this program.
    patina: &'static str,
    /// The glTF file.
    scene: String,
    /// The look file.
    look: Option<String>,
    device: DeviceFacts,
    /// Each one's part, where several devices rendered together.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    devices: Vec<DeviceShare>,
    /// Pixels.
    width: u32,
    /// Pixels.
    height: u32,
    /// As asked for; `null` where something else ends the picture and nobody has said how many.
    samples_per_pixel: Option<u32>,
    /// Taken by the pixel with the fewest; less than asked for after Ctrl-C.
    samples_per_pixel_done: u32,
    max_depth: u32,
    seed: u32,
    seconds: Seconds,
    stats: Stats,
    /// Nodes and AO tables, the most expensive first; the list may end before all of them were measured.
    textures: TextureCosts,
}

/// Wall-clock time by stage.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Seconds {
    /// Reading scene and look.
    pub(crate) load: f64,
    /// Opening the device, building acceleration structures and pipelines.
    pub(crate) prepare: f64,
    /// Rendering and reading the film back.
    pub(crate) render: f64,
}

impl RenderJob {
    /// Samples per pixel as asked for; `None` where something else ends the picture and nobody has said how many.
    fn spp_asked_for(&self) -> Option<u32> {
        let is_said = self.whole_spp != MAX_SPP || self.limits == Limits::default();
        is_said.then(|| self.spp.get())
    }

    /// So many samples per pixel, and of how many, as far as that was asked for: `3 of 64 samples`.
    pub(crate) fn samples_told(&self, done: u32) -> String {
        told(done, self.spp_asked_for())
    }
}

fn told(done: u32, asked_for: Option<u32>) -> String {
    match asked_for {
        Some(spp) => format!("{done} of {spp} samples"),
        None => format!("{done} samples"),
    }
}

impl Report {
    /// Collects the figures of a finished (or interrupted) render.
    pub(crate) fn new(
        job: &RenderJob,
        device: DeviceFacts,
        devices: Vec<DeviceShare>,
        tally: &Tally,
        seconds: Seconds,
        stats: Stats,
        textures: TextureCosts,
    ) -> Self {
        Self {
            patina: env!("CARGO_PKG_VERSION"),
            scene: job.scene.display().to_string(),
            look: job.look.as_ref().map(|look| look.display().to_string()),
            device,
            devices,
            width: job.width,
            height: job.height,
            samples_per_pixel: job.spp_asked_for(),
            samples_per_pixel_done: tally.sample_bounds().0,
            max_depth: job.max_depth,
            seed: job.seed,
            seconds,
            stats,
            textures,
        }
    }

    /// The figures as a table for people.
    pub(crate) fn table(&self) -> String {
        let mut text = String::new();
        let stats = &self.stats;
        let _ = writeln!(text, "\n{}", self.device.title);
        let _ = writeln!(
            text,
            "{}x{}, {} per pixel\n",
            self.width,
            self.height,
            told(self.samples_per_pixel_done, self.samples_per_pixel)
        );
        if stats.timestamps {
            let _ = writeln!(
                text,
                "{:<16}{:>12}{:>9}{:>12}",
                "pass", "ms", "share", "dispatches"
            );
            for pass in &stats.passes {
                let _ = writeln!(
                    text,
                    "{:<16}{:>12.1}{:>8.1}%{:>12}",
                    pass.name,
                    pass.milliseconds,
                    pass.share * 100.0,
                    console::grouped(pass.dispatches)
                );
            }
        } else {
            let _ = writeln!(
                text,
                "This device has no timestamps: there are no times per pass."
            );
        }
        self.add_textures(&mut text);
        self.add_devices(&mut text);
        let Seconds {
            load,
            prepare,
            render,
        } = self.seconds;
        let _ = writeln!(
            text,
            "\ntime            load {load:.2} s, prepare {prepare:.2} s, render {render:.2} s\n\
             rays            {} ({:.2} Mrays/s)\n\
             samples         {} samples/s\n\
             created         {} pipelines, {} shader modules",
            console::grouped(stats.rays),
            stats.mrays_per_second,
            console::grouped(stats.samples_per_second.max(0.0) as u64),
            stats.pipelines_created,
            stats.shader_modules_created
        );
        let total = stats.memory.iter().map(|(_, bytes)| bytes).sum();
        let parts: Vec<_> = stats
            .memory
            .iter()
            .map(|(name, bytes)| format!("{name} {}", console::bytes(*bytes)))
            .collect();
        let _ = writeln!(
            text,
            "memory          {}: {}",
            console::bytes(total),
            parts.join(", ")
        );
        text
    }

    /// Who rendered how much.
    fn add_devices(&self, text: &mut String) {
        if self.devices.is_empty() {
            return;
        }
        let _ = writeln!(
            text,
            "\n{:<36}{:>9}{:>12}{:>10}{:>8}",
            "device", "share", "samples/s", "time, s", "ranges"
        );
        for share in &self.devices {
            let _ = writeln!(
                text,
                "{:<36}{:>8.1}%{:>12}{:>10.2}{:>8}{}",
                share.device.name,
                share.share * 100.0,
                console::grouped(share.samples_per_second as u64),
                share.seconds,
                share.ranges,
                if share.failure.is_some() {
                    "  failed"
                } else {
                    ""
                }
            );
        }
    }

    /// The textures that take longest.
    fn add_textures(&self, text: &mut String) {
        let TextureCosts { list, is_done } = &self.textures;
        if list.is_empty() {
            return;
        }
        let _ = writeln!(
            text,
            "\n{:<32}{:>12}{:>12}{:>12}",
            "node (texture), at first hits", "ms/sample", "runs/pixel", "ns/run"
        );
        let pixels = f64::from(self.width) * f64::from(self.height);
        for cost in list.iter().take(EXPENSIVE) {
            let texture = cost.texture.as_deref().unwrap_or("ambient occlusion");
            let _ = writeln!(
                text,
                "{:<32}{:>12.2}{:>12.2}{:>12.0}",
                format!("{} ({texture})", cost.name),
                cost.per_sample() * pixels * 1e-6,
                cost.runs_per_pixel,
                cost.nanoseconds
            );
        }
        let rest = list.len().saturating_sub(EXPENSIVE);
        if rest > 0 || !is_done {
            let others = if *is_done {
                "are cheaper"
            } else {
                "are cheaper, and some have not been measured"
            };
            let _ = writeln!(text, "{rest} more {others}");
        }
    }

    /// Writes the figures as JSON, all or nothing.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn write_json(&self, path: &Path) -> Result<(), OutputError> {
        output::write_aside(path, |file| {
            serde_json::to_writer_pretty(&mut *file, self)?;
            file.write_all(b"\n")
        })
    }
}
