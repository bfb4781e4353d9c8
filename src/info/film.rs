//! `patina info` of a partial render: which samples it has, and of what.

use std::borrow::Cow;
use std::path::Path;

use serde::Serialize;

use crate::console::grouped;
use crate::failure::Failure;

use super::table::table;

/// A partial render.
#[derive(Serialize)]
pub(super) struct FilmInfo {
    file: String,
    width: u32,
    height: u32,
    /// Which samples it has: from the first up to, but not including, the second number.
    ranges: Vec<[u32; 2]>,
    /// Of the pixel with the fewest, and of that with the most.
    samples_per_pixel: [u32; 2],
    layers: Vec<Cow<'static, str>>,
    device: String,
    scene: String,
    look: Option<String>,
    /// What must be the same in all parts of a picture, by name.
    settings: Vec<(String, String)>,
}

impl FilmInfo {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let part = crate::picture::film(path);
        let part = part.map_err(|error| Failure::Failed(format!("{}: {error}", path.display())))?;
        let (fewest, most) = part.film.sample_bounds();
        let ranges = part.ranges().iter();
        Ok(Self {
            file: path.display().to_string(),
            width: part.film.width,
            height: part.film.height,
            ranges: ranges.map(|range| [range.start, range.end]).collect(),
            samples_per_pixel: [fewest, most],
            layers: part.film.layers().asked(),
            device: part.origin.device,
            scene: part.origin.scene,
            look: part.origin.look,
            settings: part.origin.settings,
        })
    }

    pub(super) fn text(&self) -> String {
        let ranges: Vec<_> = self
            .ranges
            .iter()
            .map(|[a, b]| format!("{a}..{b}"))
            .collect();
        let count = match self.samples_per_pixel {
            [fewest, most] if fewest == most => grouped(most.into()),
            [fewest, most] => format!("{} to {}", grouped(fewest.into()), grouped(most.into())),
        };
        let row = |name: &str, value: &str| vec![name.to_owned(), value.to_owned()];
        let rows = [
            row(
                "samples",
                &format!("{}: {count} per pixel", ranges.join(", ")),
            ),
            row("layers", &self.layers.join(", ")),
            row("scene", &self.scene),
            row("look", self.look.as_deref().unwrap_or("none")),
            row("device", &self.device),
        ];
        let settings: Vec<_> = (self.settings.iter())
            .map(|(name, value)| row(name, value))
            .collect();
        format!(
            "{}: a partial render, {}x{} pixels\n{}\nsettings\n{}",
            self.file,
            self.width,
            self.height,
            table(&rows),
            table(&settings)
        )
    }
}
