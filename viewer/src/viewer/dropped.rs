//! Files that are dropped onto the window.

use std::path::{Path, PathBuf};

use egui::{Id, Modal, Ui};
use engine::scene::import::is_scene;
use patina_panels::{PictureUse, named_from, surround_with};

use crate::link::{Command, Files};

use super::{Viewer, call, name};

/// What is done with a file, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Dropped {
    Scene,
    Look,
    Texture,
    Environment,
    /// Taken by the slot that it is dropped on.
    Image,
    Unknown,
}

fn kind(path: &Path) -> Dropped {
    if is_scene(path) {
        return Dropped::Scene;
    }
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    match ending.to_lowercase().as_str() {
        "toml" => Dropped::Look,
        "wgsl" => Dropped::Texture,
        "hdr" | "exr" => Dropped::Environment,
        "png" | "jpg" | "jpeg" | "webp" => Dropped::Image,
        _ => Dropped::Unknown,
    }
}

/// What to do about a file that isn't known: pictures of other formats can be saved as one that is.
fn remedy(path: &Path) -> &'static str {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    match ending.to_lowercase().as_str() {
        "bmp" | "gif" | "psd" | "tga" | "tif" | "tiff" => ": save it as PNG, JPEG or WebP",
        _ => "",
    }
}

impl Viewer {
    pub(super) fn take_dropped(&mut self, ui: &Ui) {
        let (files, now): (Vec<PathBuf>, f64) = ui.input(|input| {
            let files = input.raw.dropped_files.iter();
            (
                files.map(|file| file.path().to_owned()).collect(),
                input.time,
            )
        });
        // A scene and its look may come together.
        let of = |wanted| files.iter().find(|file| kind(file) == wanted).cloned();
        match (of(Dropped::Scene), of(Dropped::Look)) {
            (Some(scene), look) => self.open(Files {
                scene,
                look,
                camera: None,
            }),
            (None, Some(look)) => self.open(Files {
                look: Some(look),
                camera: None,
                ..self.scene.files.clone()
            }),
            (None, None) => {}
        }
        for file in &files {
            match kind(file) {
                Dropped::Scene | Dropped::Look => {}
                // Unless a slot takes it, which is seen when the panel has been shown.
                Dropped::Image => {
                    self.picture_to_use = Some(self.named_by_look(file));
                }
                Dropped::Texture => self.take_texture(file, now),
                Dropped::Environment => {
                    let path = self.named_by_look(file);
                    let edits = self.document_mut().map(|d| surround_with(d, &path));
                    self.edit("environment", &edits.unwrap_or_default(), now);
                }
                Dropped::Unknown => {
                    let remedy = remedy(file);
                    let text = format!(
                        "nothing is known to be done with {}{remedy}",
                        file.display()
                    );
                    self.tell(text, true, now);
                }
            }
        }
    }

    /// Asks what a picture is to be.
    pub(super) fn picture_question(&mut self, ui: &Ui) {
        let is_taken = self.slot_took_picture();
        let Some(path) = self.picture_to_use.take().filter(|_| !is_taken) else {
            return;
        };
        let material = self.shown_material().map(str::to_owned);
        let (mut is_closed, mut chosen) = (false, None);
        let shown = Modal::new(Id::unique("picture to use")).show(ui.ctx(), |ui| {
            ui.set_width(360.0);
            ui.heading(name(Path::new(&path)));
            match &material {
                Some(material) => ui.label(format!("It is to be of {material}:")),
                None => {
                    ui.label("Click on a surface first: then the picture can be its material's.")
                }
            };
            ui.horizontal_wrapped(|ui| {
                for way in PictureUse::ALL {
                    let button = egui::Button::new(way.label);
                    let button = ui.add_enabled(material.is_some(), button);
                    call(&button, &format!("Use as {}", way.label));
                    if button.clicked() {
                        chosen = Some(way);
                    }
                }
            });
            ui.separator();
            is_closed = ui.button("Cancel").clicked();
        });
        if let (Some(way), Some(material)) = (chosen, material) {
            let now = ui.input(|input| input.time);
            let edits = self.document_mut().map(|d| way.edits(d, &path, &material));
            let label = format!("{} of {material}", way.label);
            self.edit(&label, &edits.unwrap_or_default(), now);
        } else if !is_closed && !shown.should_close() {
            self.picture_to_use = Some(path);
        }
    }

    fn take_texture(&mut self, file: &Path, now: f64) {
        let Some(folder) = file.parent() else {
            return;
        };
        self.link.send(Command::TextureFolder(folder.to_owned()));
        let text = format!(
            "textures of {} can be used now; next time: --textures {}",
            folder.display(),
            folder.display()
        );
        self.tell(text, false, now);
    }

    /// A file as the look names it: from its own folder, where it lies below that.
    fn named_by_look(&self, file: &Path) -> String {
        let look = self.scene.files.look.as_deref().and_then(Path::parent);
        look.map_or_else(
            || file.display().to_string(),
            |folder| named_from(folder, file),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_their_endings() {
        for (name, expected) in [
            ("a.glb", Dropped::Scene),
            ("a.b.GLTF", Dropped::Scene),
            ("a.look.toml", Dropped::Look),
            ("rust.wgsl", Dropped::Texture),
            ("sky.hdr", Dropped::Environment),
            ("paint.PNG", Dropped::Image),
            ("paint.tga", Dropped::Unknown),
            ("paint.bmp", Dropped::Unknown),
            ("a.txt", Dropped::Unknown),
            ("a", Dropped::Unknown),
        ] {
            assert_eq!(kind(Path::new(name)), expected, "{name}");
        }
        assert!(remedy(Path::new("paint.TGA")).contains("PNG"));
        assert_eq!(remedy(Path::new("a.txt")), "");
    }
}
