//! The slot of an image: its path, a thumbnail, and how it is read.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::SystemTime;

use egui::{ColorImage, TextureHandle, TextureOptions, Ui, vec2};
use engine::scene::look::{Field, Spanned, Value, find};

use super::{Edited, choice, draft};
use crate::browse::{Browser, FileRequest, Purpose, named_from};

/// How names of pictures end that can be images.
const ENDINGS: [&str; 4] = ["png", "jpg", "jpeg", "webp"];

/// Points of a thumbnail's longer side.
const THUMBNAIL: u32 = 48;

/// Thumbnails by file, made in the background.
pub(crate) struct ImageSlot {
    thumbnails: HashMap<PathBuf, Thumbnail>,
    sender: Sender<(PathBuf, Option<ColorImage>)>,
    receiver: Receiver<(PathBuf, Option<ColorImage>)>,
}

struct Thumbnail {
    modified: Option<SystemTime>,
    texture: Option<TextureHandle>,
}

impl std::fmt::Debug for ImageSlot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ImageSlot").finish_non_exhaustive()
    }
}

impl Default for ImageSlot {
    fn default() -> Self {
        let (sender, receiver) = channel();
        Self {
            thumbnails: HashMap::new(),
            sender,
            receiver,
        }
    }
}

impl ImageSlot {
    fn thumbnail(&mut self, ctx: &egui::Context, path: &Path) -> Option<&TextureHandle> {
        while let Ok((path, image)) = self.receiver.try_recv() {
            if let (Some(slot), Some(image)) = (self.thumbnails.get_mut(&path), image) {
                let name = path.display().to_string();
                slot.texture = Some(ctx.load_texture(name, image, TextureOptions::LINEAR));
            }
        }
        let modified = std::fs::metadata(path)
            .and_then(|file| file.modified())
            .ok();
        let known = self.thumbnails.get(path);
        if known.is_none_or(|known| known.modified != modified) {
            let texture = None;
            let slot = Thumbnail { modified, texture };
            self.thumbnails.insert(path.to_owned(), slot);
            let (sender, path, ctx) = (self.sender.clone(), path.to_owned(), ctx.clone());
            // Where the system starts no more threads there is no thumbnail.
            let _ = std::thread::Builder::new().spawn(move || {
                let image = read(&path);
                // The panel may be gone by now.
                let _ = sender.send((path, image));
                ctx.request_repaint();
            });
        }
        self.thumbnails.get(path)?.texture.as_ref()
    }
}

/// Larger files have no thumbnail.
const MAX_FILE: u64 = 1 << 30;

fn read(path: &Path) -> Option<ColorImage> {
    let file = engine::input::read(path, MAX_FILE).ok()?;
    let image = image::ImageReader::new(std::io::Cursor::new(file));
    let image = image.with_guessed_format().ok()?.decode().ok()?;
    let small = image.thumbnail(THUMBNAIL, THUMBNAIL).to_rgba8();
    let size = [small.width() as usize, small.height() as usize];
    Some(ColorImage::from_rgba_unmultiplied(size, small.as_raw()))
}

/// Shows the slot of an image; `folder` is what paths are relative to.
pub(crate) fn image_slot(
    ui: &mut Ui,
    slots: &mut ImageSlot,
    browser: &mut Browser,
    label: &str,
    folder: &Path,
    written: Option<&Value>,
) -> Edited<Value> {
    let fields: &[Field] = match written {
        Some(Value::Table(fields)) => fields,
        _ => &[],
    };
    let file = match written {
        Some(Value::Text(path)) => path.as_str(),
        _ => match find(fields, "file").map(|file| &file.value) {
            Some(Value::Text(path)) => path.as_str(),
            _ => "",
        },
    };
    let mut value = None;
    let area = ui.vertical(|ui| {
        ui.horizontal(|ui| {
            let size = vec2(THUMBNAIL as f32, THUMBNAIL as f32);
            let thumbnail = match file {
                "" => None,
                _ => slots.thumbnail(ui.ctx(), &folder.join(file)),
            };
            let (place, _) = ui.allocate_exact_size(size, egui::Sense::hover());
            match thumbnail {
                Some(texture) => {
                    let own = texture.size_vec2();
                    let fitted = own * (size.x / own.max_elem());
                    let place = egui::Rect::from_center_size(place.center(), fitted);
                    egui::Image::new(texture).paint_at(ui, place);
                }
                None => {
                    let background = ui.visuals().extreme_bg_color;
                    ui.painter().rect_filled(place, 2.0, background);
                }
            }
            let (field, browsed) = match browser.has_system() {
                // Both fit beside the thumbnail.
                true => {
                    ui.vertical(|ui| path_field(ui, browser, label, folder, file))
                        .inner
                }
                false => path_field(ui, browser, label, folder, file),
            };
            if let Some(path) = field.value {
                value = Some(with_key(fields, "file", Value::Text(path)));
            }
            let field = field.response;
            if let Some(taken) = dropped_on(ui, field.rect.union(place)).or(browsed) {
                let path = named_from(folder, &taken);
                value = Some(with_key(fields, "file", Value::Text(path)));
            }
        });
        if file.is_empty() {
            return;
        }
        ui.horizontal_wrapped(|ui| {
            for (key, words) in [
                (
                    "color_space",
                    ["srgb", "linear", "by its texture"].as_slice(),
                ),
                ("wrap", ["repeat", "mirror", "clamp"].as_slice()),
                ("filter", ["linear", "nearest"].as_slice()),
            ] {
                let selected = match find(fields, key).map(|value| &value.value) {
                    Some(Value::Text(word)) => word.as_str(),
                    Some(_) => "u and v differ",
                    None if key == "color_space" => words[2],
                    None => words[0],
                };
                let spoken = format!("{label} {}", key.replace('_', " "));
                if let Some(word) = choice(ui, &spoken, selected, words).value {
                    let file = find(fields, "file").is_none();
                    let file = file.then(|| field("file", Value::Text(file_text(written))));
                    let fields: Vec<Field> = file.into_iter().chain(fields.to_vec()).collect();
                    value = Some(with_key(&fields, key, Value::Text(word)));
                }
            }
        });
    });
    Edited {
        response: area.response,
        value,
    }
}

/// The path, and what was chosen in a dialog of the system.
fn path_field(
    ui: &mut Ui,
    browser: &mut Browser,
    label: &str,
    folder: &Path,
    file: &str,
) -> (Edited<String>, Option<PathBuf>) {
    let field = draft(ui, label, "path of an image, or drop one here", file, 260.0);
    let request = || FileRequest {
        title: format!("Image for {label}"),
        purpose: Purpose::Open,
        kind: "Pictures",
        endings: ENDINGS.to_vec(),
        start: folder.join(file),
    };
    let browsed = browser.button(ui, "Browse ...", label, request);
    (field, browsed)
}

fn file_text(written: Option<&Value>) -> String {
    match written {
        Some(Value::Text(path)) => path.clone(),
        _ => String::new(),
    }
}

fn field(key: &str, value: Value) -> Field {
    Field {
        key: Spanned::new(key.to_owned(), 0..0),
        value: Spanned::new(value, 0..0),
    }
}

/// The image with a key set; a plain path where there is nothing else to be said.
fn with_key(fields: &[Field], key: &str, value: Value) -> Value {
    let mut fields = fields.to_vec();
    match fields.iter_mut().find(|field| field.key.value == key) {
        Some(field) => field.value.value = value,
        None => fields.push(field(key, value)),
    }
    // What goes without saying isn't written.
    fields.retain(|field| field.value.value != Value::Text("by its texture".to_owned()));
    match fields.as_slice() {
        [file] if file.key.value == "file" => file.value.value.clone(),
        _ => Value::Table(fields),
    }
}

fn dropped_on(ui: &Ui, place: egui::Rect) -> Option<PathBuf> {
    if !ui.rect_contains_pointer(place) {
        return None;
    }
    ui.input(|input| {
        let dropped = input.raw.dropped_files.first()?;
        Some(dropped.path().to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_is_a_path_until_more_is_said() {
        let text = |text: &str| Value::Text(text.to_owned());
        let path = with_key(&[], "file", text("a.png"));
        assert_eq!(path, text("a.png"));
        let file = [field("file", text("a.png"))];
        let Value::Table(fields) = with_key(&file, "wrap", text("clamp")) else {
            panic!("a table is needed");
        };
        assert_eq!(fields.len(), 2);
        let again = with_key(&file, "color_space", text("by its texture"));
        assert_eq!(again, text("a.png"));
    }
}
