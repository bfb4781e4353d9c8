//! `patina info` of a picture: its size, channels, and what its header says.

use std::path::Path;

use engine::input;
use pictures::{Facts, PartFacts};
use serde::Serialize;

use crate::failure::Failure;
use crate::picture::{MAX_FILE, unread};

use super::table::{section, table};

/// So many bytes say whether a file is a picture.
const START: u64 = 32;

/// A picture.
#[derive(Serialize)]
pub(super) struct PictureInfo {
    file: String,
    #[serde(flatten)]
    facts: Facts,
}

/// Whether a file is a picture, by how it begins.
///
/// # Errors
/// It can't be read.
pub(super) fn is_picture(path: &Path) -> Result<bool, Failure> {
    let start = input::read_start(path, START).map_err(|error| unread(path, error))?;
    Ok(Facts::is_picture(&start))
}

impl PictureInfo {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = input::read(path, MAX_FILE).map_err(|error| unread(path, error))?;
        let facts = Facts::read(&bytes);
        let facts = facts.map_err(|error| Failure::Failed(format!("{}: {error}", path.display())));
        Ok(Self {
            file: path.display().to_string(),
            facts: facts?,
        })
    }

    pub(super) fn text(&self) -> String {
        let mut text = format!("{}: {}", self.file, self.facts.format);
        for part in &self.facts.parts {
            text += &part_text(part);
        }
        text
    }
}

fn part_text(part: &PartFacts) -> String {
    let mut title = format!(", {}x{} pixels", part.width, part.height);
    if let Some(name) = &part.name {
        title = format!("\npart {name}{title}");
    }
    if let Some([x, y]) = part.position {
        title += &format!(" from {x}, {y}");
    }
    if let Some(compression) = &part.compression {
        title += &format!(", {compression}");
    }
    let channels: Vec<_> = (part.channels.iter())
        .map(|channel| vec![channel.name.clone(), channel.kind.to_owned()])
        .collect();
    let facts: Vec<_> = (part.metadata.iter())
        .map(|(name, value)| vec![name.clone(), value.clone()])
        .collect();
    let mut text = title + "\n" + &section("channels", &channels);
    if !facts.is_empty() {
        text += "\nmetadata\n";
        text += &table(&facts);
    }
    text
}
