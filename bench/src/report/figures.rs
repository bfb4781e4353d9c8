//! All that was measured, as JSON and as tables of text.

use std::fmt::Write as _;

use crate::spread::Spread;
use crate::sweeps::{LeftOut, SweepReport};
use crate::textures::{Absent, TextureResult};
use engine::stats::grouped;
use serde::Serialize;

use super::conditions::Conditions;
use super::paper::Published;

/// The JSON form is read by other programs: fields are added, never renamed. `docs/benchmarks.md` says what they are.
#[derive(Debug, Serialize)]
pub struct Figures {
    /// How they were measured.
    #[serde(flatten)]
    pub conditions: Conditions,
    /// What was rendered.
    pub scene: String,
    /// What was textured.
    pub material: String,
    /// Those of each instance counted.
    pub triangles: u64,
    /// Share of the camera's rays that meet the material first, 0 to 1.
    pub coverage: f64,
    /// The rows of all tables.
    pub results: Vec<TextureResult>,
    /// Forms without results.
    pub absent: Vec<Absent>,
    /// Whose driver told registers and stack.
    pub statistics_device: Option<String>,
    /// Why nothing is known of them, if that is so.
    pub statistics_absent: Option<String>,
    /// What changes the cost.
    pub sweeps: Vec<SweepReport>,
    /// Figures of the paper, not of this machine.
    pub paper: &'static [Published],
}

impl Figures {
    /// As JSON, with a line end behind it.
    ///
    /// # Errors
    /// None is known.
    pub fn json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }

    /// The numbers of AO rays, in the order of the tables.
    pub(super) fn ao_rays(&self) -> Vec<u32> {
        let mut numbers: Vec<u32> = self.results.iter().map(|row| row.ao_rays).collect();
        numbers.dedup();
        numbers
    }

    /// What the driver says about the kernels, if anything.
    fn statistics(&self, text: &mut String) {
        if let Some(device) = &self.statistics_device {
            let _ = writeln!(text, "registers and stack on {device}:");
        }
        for row in self.results.iter().filter(|row| row.registers.is_some()) {
            let figure = |known: Option<f64>| known.map_or("-".to_owned(), |v| v.to_string());
            let _ = writeln!(
                text,
                "  {} {}, {} AO rays: {} registers, {} bytes of stack, {} spills",
                row.mode,
                shown(row.texture),
                row.ao_rays,
                figure(row.registers),
                figure(row.stack_bytes),
                figure(row.spills)
            );
        }
    }

    /// For people, on a terminal.
    pub fn table(&self) -> String {
        let mut text = self.conditions.text();
        // Writing to a string can't fail.
        let _ = writeln!(
            text,
            "{}: {} triangles, {} covers {:.1} % of the picture",
            self.scene,
            grouped(self.triangles),
            self.material,
            self.coverage * 100.0
        );
        self.statistics(&mut text);
        for ao_rays in self.ao_rays() {
            let _ = writeln!(
                text,
                "\n{ao_rays} AO rays\n{:<9}{:<11}{:>10}  {:<28}{:>8}{:>10}{:>11}{:>12}{:>11}",
                "form",
                "texture",
                "ms/spp",
                "over grey",
                "bytes",
                "edit, ms",
                " pipelines",
                " source, ms",
                " known, ms"
            );
            for row in self.results.iter().filter(|row| row.ao_rays == ao_rays) {
                write_row(&mut text, row);
            }
        }
        for Absent { mode, reason } in &self.absent {
            let _ = writeln!(text, "{mode}: {reason}");
        }
        for sweep in &self.sweeps {
            write_sweep(&mut text, sweep);
        }
        text
    }
}

/// A texture as people read it; its name in JSON stays.
pub(super) fn shown(texture: &str) -> &str {
    match texture {
        "gray" => "grey",
        other => other,
    }
}

/// `+12.3 % (+11.0 to +14.2)`
pub(super) fn percent(spread: &Spread) -> String {
    let Spread { median, low, high } = spread;
    format!("{median:+.1} % ({low:+.1} to {high:+.1})")
}

/// `12.3 (11.0 to 14.2)`
pub(super) fn milliseconds(spread: &Spread) -> String {
    let Spread { median, low, high } = spread;
    format!("{median:.2} ({low:.2} to {high:.2})")
}

/// A value of a sweep: whole, or a share with a digit more.
pub(super) fn value(value: f64) -> String {
    match value.fract() == 0.0 {
        true => format!("{value:.0}"),
        false => format!("{value:.1}"),
    }
}

/// A value without points, as what it is.
pub(super) fn value_left_out(left_out: &LeftOut) -> String {
    match left_out.setting {
        Some(setting) => format!("{setting} {}", left_out.value),
        None => value(left_out.value),
    }
}

fn write_row(text: &mut String, row: &TextureResult) {
    let increase = match row.texture {
        "gray" => String::new(),
        _ => percent(&row.increase),
    };
    let _ = writeln!(
        text,
        "{:<9}{:<11}{:>10.1}  {increase:<28}{:>8}{:>10.1}{:>11}{:>12.0}{:>11.0}",
        row.mode,
        shown(row.texture),
        row.ms_per_spp.median,
        row.private_bytes,
        row.edit_ms,
        row.pipelines_created,
        row.source_edit_ms,
        row.build_ms_warm
    );
}

impl SweepReport {
    /// For people, on a terminal: an empty line, and what [`Figures::table`] has of it.
    pub fn table(&self) -> String {
        let mut text = String::new();
        write_sweep(&mut text, self);
        text
    }
}

fn write_sweep(text: &mut String, sweep: &SweepReport) {
    let _ = writeln!(text, "\n{}, {}", sweep.label, sweep.texture);
    let _ = writeln!(text, "{:>8}  {:<9}{:>10}  over grey", "", "form", "ms/spp");
    for point in &sweep.points {
        let _ = writeln!(
            text,
            "{:>8}  {:<9}{:>10.1}  {}",
            value(point.value),
            point.mode,
            point.ms_per_spp.median,
            percent(&point.increase)
        );
    }
    for left_out in &sweep.left_out {
        let _ = writeln!(text, "{:>8}  {}", value_left_out(left_out), left_out.reason);
    }
    for Absent { mode, reason } in &sweep.absent {
        let _ = writeln!(text, "{:>8}  {mode}: {reason}", "");
    }
    if let Some(reason) = &sweep.ended {
        let _ = writeln!(text, "{:>8}  further values left out: {reason}", "");
    }
}
