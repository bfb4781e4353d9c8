//! What was measured, as JSON for programs and as Markdown for people.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;

use anyhow::{Context, Result};
use serde::Serialize;

use super::exchange::{Comparison, Listed, Outcome, Spread, TextureCase};
use super::fit::Falling;

/// Everything. Fields are added, never renamed.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    /// Of the processor.
    machine: String,
    threads: u32,
    /// What was skipped and why.
    notices: Vec<String>,
    pub(super) scenes: Vec<SceneReport>,
    pub(super) textures: Vec<TextureReport>,
}

/// A scene without textures that are programmed.
#[derive(Debug, Serialize)]
pub(super) struct SceneReport {
    scene: String,
    width: u32,
    height: u32,
    triangles: u64,
    /// `given`; `own` where each peer is held against its own converged picture; or the peer that made one for all.
    reference: String,
    /// The error that the times are for: the highest that any peer has at its most samples.
    target_error: f64,
    rows: Vec<Row>,
}

/// A peer on a scene.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    peer: String,
    version: String,
    details: String,
    /// Of a render with the most samples per pixel; without loading.
    samples_per_second: Spread,
    load_seconds: Spread,
    /// Root mean square of the relative errors of all runs.
    errors: Vec<ErrorAt>,
    /// p of an error that falls as N^-p.
    exponent: Option<f64>,
    seconds_to_target: Option<f64>,
    /// Mean of the picture over that of the common reference.
    level: f64,
    /// Relative error against the common reference.
    unlike: f64,
    #[serde(skip)]
    pixels: f64,
}

/// An error at so many samples per pixel.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct ErrorAt {
    spp: u32,
    relative_rmse: f64,
}

/// What is known of a peer on a scene.
pub(super) struct Measured<'a> {
    /// Of each run.
    pub(super) outcomes: &'a [Outcome],
    /// All pictures against the peer's reference.
    pub(super) errors: &'a Comparison,
    /// Its best picture against the common reference.
    pub(super) alike: &'a Comparison,
    pub(super) pixels: f64,
}

/// A scene with programmed textures.
#[derive(Debug, Serialize)]
pub(super) struct TextureReport {
    scene: String,
    width: u32,
    height: u32,
    triangles: u64,
    rows: Vec<TextureRow>,
}

/// A texture of a peer.
#[derive(Debug, Serialize)]
pub(super) struct TextureRow {
    peer: String,
    form: String,
    texture: String,
    ao_rays: u32,
    ms_per_spp: f64,
    increase_percent: Spread,
    edit_ms: f64,
    unedited_ms: f64,
}

impl Report {
    pub(super) fn new(threads: u32, notices: Vec<String>) -> Self {
        Self {
            machine: machine(),
            threads,
            notices,
            scenes: Vec::new(),
            textures: Vec::new(),
        }
    }

    pub(super) fn markdown(&self) -> String {
        let mut text = format!(
            "# Patina and its peers\n\n{}, {} threads\n",
            self.machine, self.threads
        );
        for notice in &self.notices {
            let _ = writeln!(text, "- {notice}");
        }
        for scene in &self.scenes {
            scene.write(&mut text);
        }
        for scene in &self.textures {
            scene.write(&mut text);
        }
        text
    }
}

impl Row {
    /// # Errors
    /// The peer rendered nothing.
    pub(super) fn new(peer: &str, version: &str, measured: &Measured<'_>) -> Result<Self> {
        let outcomes = measured.outcomes;
        let first = outcomes.first().context("a peer without a run")?;
        let mut rates = Vec::new();
        for outcome in outcomes {
            let longest = outcome
                .renders
                .last()
                .with_context(|| format!("{peer} rendered nothing"))?;
            rates.push(measured.pixels * f64::from(longest.spp) / longest.seconds);
        }
        let mut squares: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
        for error in &measured.errors.errors {
            squares
                .entry(error.spp)
                .or_default()
                .push(error.relative_rmse.powi(2));
        }
        let errors: Vec<ErrorAt> = squares
            .into_iter()
            .map(|(spp, squares)| ErrorAt {
                spp,
                relative_rmse: (squares.iter().sum::<f64>() / squares.len() as f64).sqrt(),
            })
            .collect();
        let alike = measured
            .alike
            .errors
            .first()
            .context("nothing was compared")?;
        Ok(Self {
            peer: peer.to_owned(),
            version: version.to_owned(),
            details: first.details.clone(),
            samples_per_second: Spread::of(rates),
            load_seconds: Spread::of(outcomes.iter().map(|outcome| outcome.load_seconds)),
            exponent: falling(&errors).map(|fit| fit.exponent),
            errors,
            seconds_to_target: None,
            level: alike.level,
            unlike: alike.relative_rmse,
            pixels: measured.pixels,
        })
    }

    fn last_error(&self) -> f64 {
        self.errors.last().map_or(0.0, |error| error.relative_rmse)
    }

    /// Seconds of rendering until the error is so low, by the fit and the rate of the longest render.
    fn seconds_to(&self, error: f64) -> Option<f64> {
        let samples = falling(&self.errors)?.samples(error)?;
        Some(samples * self.pixels / self.samples_per_second.median)
    }
}

fn falling(errors: &[ErrorAt]) -> Option<Falling> {
    let points: Vec<_> = errors
        .iter()
        .map(|e| (f64::from(e.spp), e.relative_rmse))
        .collect();
    Falling::through(&points)
}

impl SceneReport {
    pub(super) fn new(scene: &Listed, reference: String, mut rows: Vec<Row>) -> Self {
        let target_error = rows.iter().map(Row::last_error).fold(0.0, f64::max);
        for row in &mut rows {
            row.seconds_to_target = row.seconds_to(target_error);
        }
        Self {
            scene: scene.name.clone(),
            width: scene.width,
            height: scene.height,
            triangles: scene.triangles,
            reference,
            target_error,
            rows,
        }
    }

    fn write(&self, text: &mut String) {
        let Self {
            scene,
            width,
            height,
            triangles,
            reference,
            target_error,
            ..
        } = self;
        let _ = write!(
            text,
            "\n## {scene}, {width}x{height}, {triangles} triangles, reference: {reference}\n\n\
             | renderer | Msamples/s (range) | error | falls as N^-p | s to error {target_error:.4} | level | unlike | load, s |\n\
             |---|---|---|---|---|---|---|---|\n"
        );
        let optional = |value: Option<f64>, digits: usize| {
            value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
        };
        for row in &self.rows {
            let rate = row.samples_per_second;
            let errors: Vec<_> = row
                .errors
                .iter()
                .map(|e| format!("{}: {:.4}", e.spp, e.relative_rmse))
                .collect();
            let _ = writeln!(
                text,
                "| {} {} ({}) | {:.3} ({:.3}-{:.3}) | {} | {} | {} | {:.4} | {:.4} | {:.1} |",
                row.peer,
                row.version,
                row.details,
                rate.median * 1e-6,
                rate.low * 1e-6,
                rate.high * 1e-6,
                errors.join(", "),
                optional(row.exponent, 2),
                optional(row.seconds_to_target, 1),
                row.level,
                row.unlike,
                row.load_seconds.median,
            );
        }
    }
}

impl TextureReport {
    pub(super) fn new(scene: &Listed, rows: Vec<TextureRow>) -> Self {
        Self {
            scene: scene.name.clone(),
            width: scene.width,
            height: scene.height,
            triangles: scene.triangles,
            rows,
        }
    }

    fn write(&self, text: &mut String) {
        let Self {
            scene,
            width,
            height,
            triangles,
            ..
        } = self;
        let _ = write!(
            text,
            "\n## {scene}, {width}x{height}, {triangles} triangles\n\n\
             | renderer | form | texture | AO rays | ms/spp | over grey | edit to first image, ms | without an edit, ms |\n\
             |---|---|---|---|---|---|---|---|\n"
        );
        for row in &self.rows {
            let Spread { median, low, high } = row.increase_percent;
            let increase = match row.texture.as_str() {
                "gray" => String::new(),
                _ => format!("{median:+.1} % ({low:+.1} to {high:+.1})"),
            };
            let optional = |ms: f64| {
                if ms > 0.0 {
                    format!("{ms:.1}")
                } else {
                    String::new()
                }
            };
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {:.1} | {increase} | {} | {} |",
                row.peer,
                row.form,
                row.texture,
                row.ao_rays,
                row.ms_per_spp,
                optional(row.edit_ms),
                optional(row.unedited_ms),
            );
        }
    }
}

impl TextureRow {
    pub(super) fn new(peer: &str, ao_rays: u32, case: &TextureCase) -> Self {
        Self {
            peer: peer.to_owned(),
            form: case.form.clone(),
            texture: case.texture.clone(),
            ao_rays,
            ms_per_spp: case.ms_per_spp,
            increase_percent: case.increase_percent,
            edit_ms: case.edit_ms,
            unedited_ms: case.unedited_ms,
        }
    }
}

/// Name of the processor where the system tells.
fn machine() -> String {
    let told = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = told
        .lines()
        .find_map(|line| line.strip_prefix("model name"));
    let model = model.map(|line| line.trim_start_matches([' ', '\t', ':']).to_owned());
    model.unwrap_or_else(|| format!("{} processor", std::env::consts::ARCH))
}

#[cfg(test)]
mod tests {
    use super::super::exchange::{PictureError, Render, Task};
    use super::*;

    fn outcome(seconds: f64) -> Outcome {
        let render = |spp: u32| Render {
            spp,
            seconds: seconds * f64::from(spp),
            picture: "a.npy".into(),
        };
        Outcome {
            details: "CPU".to_owned(),
            load_seconds: 2.0,
            renders: vec![render(4), render(16)],
            cases: Vec::new(),
        }
    }

    /// A peer whose samples take so long and whose error is so large at one sample, falling as N^-0.5.
    fn row(peer: &str, seconds: f64, error: f64) -> Row {
        let at = |spp: u32| PictureError {
            spp,
            relative_rmse: error / f64::from(spp).sqrt(),
            level: 1.0,
        };
        // Two runs, whose pictures come one after the other.
        let errors = Comparison {
            errors: vec![at(4), at(16), at(4), at(16)],
        };
        let alike = Comparison {
            errors: vec![at(16)],
        };
        let outcomes = [outcome(seconds), outcome(seconds)];
        let measured = Measured {
            outcomes: &outcomes,
            errors: &errors,
            alike: &alike,
            pixels: 1000.0,
        };
        Row::new(peer, "1.0", &measured).unwrap()
    }

    fn scene() -> Listed {
        Listed {
            name: "box".to_owned(),
            task: Task::Render,
            file: "box.gltf".into(),
            width: 40,
            height: 25,
            triangles: 12,
            environment: [0.0; 3],
            reference: None,
        }
    }

    #[test]
    fn half_the_noise_is_a_quarter_of_the_time() {
        let report = SceneReport::new(
            &scene(),
            "own".to_owned(),
            vec![row("slow", 1.0, 0.8), row("fast", 1.0, 0.4)],
        );
        assert!((report.target_error - 0.2).abs() < 1e-12);
        let seconds: Vec<f64> = report
            .rows
            .iter()
            .map(|row| row.seconds_to_target.unwrap())
            .collect();
        assert!(
            (seconds[0] - 16.0).abs() < 1e-6 && (seconds[1] - 4.0).abs() < 1e-6,
            "{seconds:?}"
        );
        assert!((report.rows[0].samples_per_second.median - 1000.0).abs() < 1e-9);
    }

    #[test]
    fn tables_have_a_row_for_each_peer() {
        let mut report = Report::new(2, vec!["luxcore: skipped".to_owned()]);
        report.scenes.push(SceneReport::new(
            &scene(),
            "own".to_owned(),
            vec![row("patina", 1.0, 0.5)],
        ));
        let spread = Spread {
            median: 20.0,
            low: 18.0,
            high: 21.0,
        };
        let case = TextureCase {
            form: "nodes".to_owned(),
            texture: "rust".to_owned(),
            ms_per_spp: 12.0,
            increase_percent: spread,
            edit_ms: 30.0,
            unedited_ms: 20.0,
        };
        let rows = vec![TextureRow::new("cycles", 16, &case)];
        report.textures.push(TextureReport::new(&scene(), rows));
        let text = report.markdown();
        for expected in [
            "luxcore: skipped",
            "| patina 1.0 (CPU) | 0.001 (0.001-0.001) | 4: 0.2500, 16: 0.1250 | 0.50 | 16.0 | 1.0000 |",
            "| cycles | nodes | rust | 16 | 12.0 | +20.0 % (+18.0 to +21.0) | 30.0 | 20.0 |",
        ] {
            assert!(text.contains(expected), "{expected}\n{text}");
        }
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(json["scenes"][0]["rows"][0]["peer"], "patina");
    }
}
