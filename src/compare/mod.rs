//! `patina compare`: how far a picture is from a reference, in figures and as a picture. What the figures are is the crate
//! `pictures`' business.

pub(crate) mod args;
pub(crate) mod job;
mod stripes;

use std::fmt::Write as _;
use std::path::PathBuf;

use pictures::{Distance, heat};
use serde::Serialize;

use crate::failure::Failure;
use crate::{console, output, picture};

use job::{CompareJob, Most};

/// Compares, tells, and judges.
///
/// # Errors
/// A picture can't be read or has no such layer, there isn't the memory for them, they differ in size, or they are further apart than they
/// may be.
pub(crate) fn run(job: &CompareJob) -> Result<(), Failure> {
    let written: Vec<PathBuf> = job.diff.iter().map(|diff| diff.path.clone()).collect();
    output::check_all(&written, &[job.picture.clone(), job.reference.clone()])?;
    stripes::check(job)?;
    let judged = picture::placed(&job.picture, job.layer.as_deref())?;
    let by = picture::placed(&job.reference, job.layer.as_deref())?;
    let (layer, reference) = (judged.layer, by.layer);
    let distance = stripes::distance(&layer, &reference, job.exposure).map_err(|error| {
        Failure::Failed(format!(
            "{} and {}: {error}",
            job.picture.display(),
            job.reference.display()
        ))
    })?;
    if let (Some(_), None) | (None, Some(_)) = (layer.alpha(), reference.alpha()) {
        console::warning("alpha isn't compared: only one of the pictures has it");
    }
    if let Some(warning) = apart(judged.place, by.place) {
        console::warning(&warning);
    }
    let [width, height] = layer.size;
    if let Some(diff) = &job.diff {
        // Sides have at most 32768 pixels.
        let size = [width as u32, height as u32];
        let shown = heat::rgba(&distance.map);
        output::write_shown(diff, size, &shown).map_err(Failure::because)?;
        if !job.json {
            console::note(&format!("wrote {}", diff.path.display()));
        }
    }
    let exceeded = exceeded(&job.most, &distance, layer.title())?;
    let report = Report {
        picture: job.picture.display().to_string(),
        reference: job.reference.display().to_string(),
        layer: layer.title(),
        width,
        height,
        exposure: job.exposure,
        distance: &distance,
        passed: exceeded.is_empty(),
    };
    match job.json {
        true => {
            let json = serde_json::to_string_pretty(&report).map_err(Failure::because)?;
            console::print(&json);
        }
        false => console::print(&report.text()),
    }
    match exceeded.is_empty() {
        true => Ok(()),
        false => Err(Failure::Failed(exceeded.join("\n"))),
    }
}

/// The figures; their JSON form is read by other programs: fields are added, never renamed.
#[derive(Serialize)]
struct Report<'a> {
    picture: String,
    reference: String,
    layer: &'a str,
    width: usize,
    height: usize,
    /// Stops.
    exposure: f32,
    #[serde(flatten)]
    distance: &'a Distance,
    /// No `--max` is exceeded.
    passed: bool,
}

impl Report<'_> {
    fn text(&self) -> String {
        let Distance {
            mse,
            relative_mse,
            largest,
            changed,
            psnr,
            flip,
            map: _,
        } = self.distance;
        let mut text = format!(
            "{}, {}x{} pixels: {} against {}\n",
            self.layer, self.width, self.height, self.picture, self.reference
        );
        let mut row = |name: &str, value: String| {
            let _ = writeln!(text, "  {name:<20}{value}");
        };
        row("MSE", number(*mse));
        row("relative MSE", number(*relative_mse));
        if let (Some(psnr), Some(flip)) = (psnr, flip) {
            row("PSNR", format!("{psnr:.2} dB"));
            row("FLIP", number(*flip));
        }
        row("largest difference", number(*largest));
        row("changed pixels", format!("{:.2} %", changed * 100.0));
        text
    }
}

/// What is said of pictures that don't lie in the same place, by column and row of their upper left pixels.
fn apart(place: Option<[i32; 2]>, reference: Option<[i32; 2]>) -> Option<String> {
    let ([column, row], [other_column, other_row]) = place.zip(reference)?;
    ((column, row) != (other_column, other_row)).then(|| {
        format!(
            "the picture begins at column {column} and row {row}, and the reference at column {other_column} and row {other_row} \
             (\"data window\"): they are compared as if they lay in the same place"
        )
    })
}

/// With the digits that say something, however small it is.
fn number(value: f64) -> String {
    match value == 0.0 || !value.is_finite() || (1e-3..1e6).contains(&value.abs()) {
        true => format!("{value:.6}"),
        false => format!("{value:.4e}"),
    }
}

/// Sentences about what is larger than it may be.
fn exceeded(most: &Most, distance: &Distance, layer: &str) -> Result<Vec<String>, Failure> {
    let flip = match (most.flip, distance.flip) {
        (Some(_), None) => {
            return Err(Failure::Failed(format!(
                "--max-flip: {layer} has no colours, and FLIP compares colours; use --max-mse or --max-relative-mse"
            )));
        }
        (_, flip) => flip.unwrap_or_default(),
    };
    let limits = [
        ("FLIP", "--max-flip", flip, most.flip),
        ("the MSE", "--max-mse", distance.mse, most.mse),
        (
            "the relative MSE",
            "--max-relative-mse",
            distance.relative_mse,
            most.relative_mse,
        ),
    ];
    let sentence = |(what, flag, found, most): (&str, &str, f64, Option<f32>)| {
        let most = most?;
        // A number as it was typed, not as single precision has it.
        let limit = most.to_string().parse().unwrap_or(f64::from(most));
        (found > limit).then(|| {
            format!(
                "{what} of {layer} is {}, more than {flag} {most}",
                number(found)
            )
        })
    };
    Ok(limits.into_iter().filter_map(sentence).collect())
}

#[cfg(test)]
mod tests {
    use pictures::Layer;

    use super::*;

    fn distance(a: f32, b: f32) -> Distance {
        let layer = |grey: f32| Layer::rgb("", [1, 1], &[[grey; 3]]);
        Distance::between(&layer(a), &layer(b), 0.0).expect("alike")
    }

    #[test]
    fn what_is_exceeded_is_named() {
        let found = distance(0.5, 0.4);
        let most = Most {
            mse: Some(0.001),
            relative_mse: Some(10.0),
            flip: Some(0.0),
        };
        let sentences = exceeded(&most, &found, "it").expect("colours");
        assert_eq!(sentences.len(), 2, "{sentences:?}");
        assert!(
            sentences[0].starts_with("FLIP of it is 0."),
            "{sentences:?}"
        );
        assert!(sentences[1].contains("--max-mse 0.001"), "{sentences:?}");
        let same = exceeded(&most, &distance(0.5, 0.5), "it").expect("colours");
        assert!(same.is_empty(), "{same:?}");
        let infinite = distance(f32::NAN, 0.5);
        let broken = exceeded(&most, &infinite, "it").expect("colours");
        assert_eq!(broken.len(), 3, "{broken:?}");
    }

    #[test]
    fn pictures_of_other_places_are_told() {
        assert_eq!(apart(Some([5, 5]), Some([5, 5])), None);
        assert_eq!(apart(Some([5, 5]), None), None);
        let warning = apart(Some([0, 0]), Some([5, -6])).expect("apart");
        assert!(warning.contains("column 5 and row -6"), "{warning}");
    }

    #[test]
    fn small_numbers_keep_their_digits() {
        assert_eq!(number(0.0), "0.000000");
        assert_eq!(number(0.25), "0.250000");
        assert_eq!(number(1.25e-9), "1.2500e-9");
        assert_eq!(number(f64::INFINITY), "inf");
    }
}
