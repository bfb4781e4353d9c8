//! `patina texture doc`: the page about all textures, and a sheet of swatches for each group.

mod page;
mod sheet;
mod shown;
mod swatch;

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::PathBuf;

use texgen::TextureType;

use crate::failure::Failure;
use crate::{console, library, output};

use super::job::DocJob;

/// Groups in the order of the page; others follow by name.
const ORDER: &[(&str, &str)] = &[
    ("noise", "Noise and cells"),
    ("patterns", "Patterns"),
    ("materials", "Materials"),
    ("weathering", "Weathering"),
    ("surface", "Surface"),
    ("images", "Images"),
    ("colour", "Colour and numbers"),
    ("coordinates", "Places and coordinates"),
    ("random", "Random numbers and time"),
];

/// What stands for a group where a texture names none.
const OTHERS: &str = "others";

/// The textures of one group, by name.
pub(super) struct Group {
    pub(super) name: String,
    pub(super) title: String,
    pub(super) textures: Vec<TextureType>,
}

/// Writes the sheets where a folder is given, then the page, or prints it.
///
/// # Errors
/// A folder can't be read, the device refuses, or a file can't be written or is a texture. Textures with errors are warned of and left
/// out.
pub(crate) fn run(job: &DocJob) -> Result<(), Failure> {
    let sources = super::sources(&job.texture_dirs, None)?;
    let mut by_group: BTreeMap<String, Vec<TextureType>> = BTreeMap::new();
    for name in sources.names() {
        let parsed = super::read(&sources, name).map_err(Into::into);
        match parsed.and_then(TextureType::parse) {
            Ok(texture) => {
                let group = texture.group().unwrap_or(OTHERS).to_owned();
                by_group.entry(group).or_default().push(texture);
            }
            Err(_) => console::warning(&format!(
                "texture `{name}` has errors: `patina texture check {name}` shows them"
            )),
        }
    }
    let groups = in_order(by_group);
    check(job, &groups, &library::files(sources.directories()))?;
    if let Some(folder) = &job.sheets {
        sheet::write_all(&groups, &sources, folder, &job.device)?;
    }
    let page = page::page(&groups);
    match &job.output {
        Some(path) => {
            output::write_aside(path, |file| file.write_all(page.as_bytes()))
                .map_err(Failure::because)?;
            console::note(&format!("wrote {}", path.display()));
        }
        None => console::print(page.trim_end()),
    }
    Ok(())
}

/// Whether all files can be written, none of them over a texture. Makes the folder of the sheets.
fn check(job: &DocJob, groups: &[Group], textures: &[PathBuf]) -> Result<(), Failure> {
    if let Some(folder) = &job.sheets {
        fs::create_dir_all(folder).map_err(|error| {
            Failure::Failed(format!("cannot create {}: {error}", folder.display()))
        })?;
    }
    let sheet = |folder: &PathBuf| {
        let names = groups.iter().map(|group| page::file_name(&group.name));
        names.map(|name| folder.join(name)).collect::<Vec<_>>()
    };
    let sheets = job.sheets.iter().flat_map(sheet);
    let written: Vec<PathBuf> = job.output.iter().cloned().chain(sheets).collect();
    output::check_all(&written, textures)
}

fn in_order(mut by_group: BTreeMap<String, Vec<TextureType>>) -> Vec<Group> {
    let mut groups = Vec::new();
    for (name, title) in ORDER {
        if let Some(textures) = by_group.remove(*name) {
            groups.push(Group {
                name: (*name).to_owned(),
                title: (*title).to_owned(),
                textures,
            });
        }
    }
    groups.extend(by_group.into_iter().map(|(name, textures)| Group {
        title: name.clone(),
        name,
        textures,
    }));
    groups
}
