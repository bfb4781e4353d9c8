//! Pictures of environments beside a look, to choose from.

use std::path::{Path, PathBuf};

use egui::{Id, Ui, vec2};
use engine::scene::look::{Section, Value};
use engine::session::{Document, Edit};

use crate::context::Context;
use crate::widgets::{menu, name, scrolled};

/// Points of a picture in the list.
const PICTURE: egui::Vec2 = vec2(96.0, 48.0);
/// Pictures that are listed, and entries of folders that are looked at for them.
const MOST: usize = 200;
const MOST_ENTRIES: usize = 5000;
/// The folders are read again after so many seconds.
const AGAIN: f64 = 2.0;

/// A menu of the pictures that lie beside the look, or one folder below.
pub(crate) fn picker(ui: &mut Ui, cx: &mut Context<'_>, text: &str) {
    let button = menu(ui, text, |ui| {
        let folder = cx.document.look().resolve("");
        let found = found(ui, &folder);
        if found.is_empty() {
            ui.weak("no .hdr or .exr lies beside the look, or in a folder there; drop one onto the window");
            return;
        }
        scrolled(ui, |ui| {
            for path in &found {
                if entry(ui, cx, path, &folder) {
                    let edits = surround_with(cx.document, &written(path, &folder));
                    cx.edit("environment: a picture", edits, None);
                    ui.close();
                }
            }
        });
    });
    name(&button.response, "Choose the environment's picture");
}

/// A picture with its name. Gives whether it was clicked.
fn entry(ui: &mut Ui, cx: &mut Context<'_>, path: &Path, folder: &Path) -> bool {
    let texture = cx
        .images
        .thumbnail(ui.ctx(), path)
        .map(egui::TextureHandle::id);
    let text = written(path, folder);
    let row = ui.horizontal(|ui| {
        let (place, _) = ui.allocate_exact_size(PICTURE, egui::Sense::hover());
        match texture {
            Some(id) => {
                let image = egui::Image::new((id, PICTURE));
                image.paint_at(ui, place);
            }
            None => {
                let background = ui.visuals().extreme_bg_color;
                ui.painter().rect_filled(place, 2.0, background);
            }
        }
        ui.button(&text).clicked()
    });
    let picture = row.response.interact(egui::Sense::click());
    row.inner || picture.clicked()
}

/// As a look writes it: relative to its folder where it lies below.
fn written(path: &Path, folder: &Path) -> String {
    let relative = path.strip_prefix(folder).unwrap_or(path);
    relative.to_string_lossy().replace('\\', "/")
}

/// Edits by which a picture, named as the look names it, is the environment in place of whatever light there was. What is said of it
/// beside that stays: intensity, turn and group.
pub fn surround_with(document: &Document, picture: &str) -> Vec<Edit> {
    let section = Section::Environment;
    let others = ["color", "sky"].into_iter();
    let others = others.filter(|key| document.value(&section, key).is_some());
    let clear = others.map(|key| Edit::Clear {
        section: Section::Environment,
        key: key.to_owned(),
    });
    let image = Edit::environment("image", Value::Text(picture.to_owned()));
    clear.chain([image]).collect()
}

/// The pictures; folders are read now and then only, while the menu is open.
fn found(ui: &Ui, folder: &Path) -> Vec<PathBuf> {
    let id = Id::unique(("environments", folder));
    let now = ui.input(|input| input.time);
    let known: Option<(f64, Vec<PathBuf>)> = ui.data(|data| data.get_temp(id));
    match known {
        Some((since, list)) if now - since < AGAIN => list,
        _ => {
            let list = pictures(folder);
            ui.data_mut(|data| data.insert_temp(id, (now, list.clone())));
            list
        }
    }
}

fn pictures(folder: &Path) -> Vec<PathBuf> {
    let entries = |folder: &Path| {
        let read = std::fs::read_dir(folder).into_iter().flatten();
        let paths = read.filter_map(|entry| Some(entry.ok()?.path()));
        paths.take(MOST_ENTRIES).collect::<Vec<_>>()
    };
    let is_picture = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str());
        ending.is_some_and(|e| {
            ["hdr", "exr"]
                .iter()
                .any(|known| e.eq_ignore_ascii_case(known))
        })
    };
    // A look without a file lies where the program was started.
    let folder = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let mut found = Vec::new();
    for path in entries(folder) {
        if is_picture(&path) {
            found.push(path);
        } else if path.is_dir() {
            found.extend(entries(&path).into_iter().filter(is_picture));
        }
    }
    found.sort();
    found.truncate(MOST);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_beside_the_look_and_one_folder_below_are_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let below = folder.path().join("skies/deep");
        std::fs::create_dir_all(&below).expect("folders");
        for file in ["b.HDR", "a.exr", "c.png", "skies/d.hdr", "skies/deep/e.hdr"] {
            std::fs::write(folder.path().join(file), "").expect("a file");
        }
        let found = pictures(folder.path());
        let names: Vec<_> = found
            .iter()
            .map(|path| written(path, folder.path()))
            .collect();
        assert_eq!(names, ["a.exr", "b.HDR", "skies/d.hdr"]);
        assert!(pictures(&folder.path().join("nowhere")).is_empty());
    }
}
