//! What whole renders took, as JSON and as tables of text.

use std::fmt::Write as _;

use engine::stats::grouped;
use serde::Serialize;

use crate::render::RenderReport;
use crate::spread::Spread;

use super::conditions::Conditions;

/// Figures of all scenes. The JSON form is read by other programs: fields are added, never renamed.
#[derive(Debug, Serialize)]
pub struct RenderFigures {
    /// How they were measured.
    #[serde(flatten)]
    pub conditions: Conditions,
    /// What came out for each scene.
    pub scenes: Vec<RenderReport>,
}

impl RenderFigures {
    /// For people, on a terminal.
    pub fn table(&self) -> String {
        let mut text = self.conditions.text();
        for scene in &self.scenes {
            write_scene(&mut text, scene);
        }
        text
    }
}

fn write_scene(text: &mut String, scene: &RenderReport) {
    let _ = writeln!(
        text,
        "\n{}: {} triangles, {} bytes per path, {} samples not finite\n",
        scene.name,
        grouped(scene.triangles),
        scene.path_bytes.total(),
        grouped(scene.invalid_samples)
    );
    let _ = writeln!(
        text,
        "{:<20}{:>12.0}  ({:.0} to {:.0})",
        "samples/s",
        scene.samples_per_second.median,
        scene.samples_per_second.low,
        scene.samples_per_second.high
    );
    for (name, rays) in [
        ("closest, Mrays/s", &scene.closest),
        ("occlusion, Mrays/s", &scene.occlusion),
        ("AO, Mrays/s", &scene.ao),
    ] {
        let Spread { median, low, high } = rays.mrays_per_second;
        if rays.rays > 0 {
            let _ = writeln!(
                text,
                "{name:<20}{median:>12.2}  ({low:.2} to {high:.2}; {} rays)",
                grouped(rays.rays)
            );
        }
    }
    if !scene.timestamps {
        let _ = writeln!(
            text,
            "This device has no timestamps: rays are counted per second of everything."
        );
        return;
    }
    let _ = writeln!(text, "\n{:<20}{:>12}{:>9}", "pass", "ms", "share");
    for pass in &scene.passes {
        let Spread { median, low, high } = pass.milliseconds;
        let _ = writeln!(
            text,
            "{:<20}{median:>12.1}{:>8.1}%  ({low:.1} to {high:.1}; {} dispatches)",
            pass.name,
            pass.share * 100.0,
            grouped(pass.dispatches)
        );
    }
}
