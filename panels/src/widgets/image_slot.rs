//! The slot of an image: its path, a thumbnail, and how it is read.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::SystemTime;

use egui::{
    Color32, ColorImage, Response, Rgba, Stroke, StrokeKind, TextureHandle, TextureOptions, Ui,
    vec2,
};
use engine::scene::FloatImage;
use engine::scene::import::load_environment_image;
use engine::scene::look::{Field, MODEL_IMAGE, Spanned, Value, find};
use engine::system::Disk;

use crate::model_image::{DraggedImage, ModelImage};

use super::browse::{Browser, FileRequest, Purpose, named_from};
use super::{Edited, choice, draft};

/// How names of pictures end that can be images, chosen or dropped. The window takes the same for pictures.
const ENDINGS: [&str; 4] = ["png", "jpg", "jpeg", "webp"];

/// Points of a thumbnail's longer side.
const THUMBNAIL: u32 = 48;
/// Pictures that are read at the same time.
const MOST_PENDING: usize = 2;

/// Thumbnails by file, made in the background.
pub(crate) struct ImageSlot {
    thumbnails: HashMap<PathBuf, Thumbnail>,
    /// So many are being made.
    pending: usize,
    /// A slot has taken a file that was dropped.
    has_taken: bool,
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
            pending: 0,
            has_taken: false,
            sender,
            receiver,
        }
    }
}

impl ImageSlot {
    /// Whether a slot has taken a file that was dropped; asked for once.
    pub(crate) fn take_dropped(&mut self) -> bool {
        std::mem::take(&mut self.has_taken)
    }

    /// A small picture of a file, once it has been made.
    pub(crate) fn thumbnail(&mut self, ctx: &egui::Context, path: &Path) -> Option<&TextureHandle> {
        while let Ok((path, image)) = self.receiver.try_recv() {
            self.pending = self.pending.saturating_sub(1);
            if let (Some(slot), Some(image)) = (self.thumbnails.get_mut(&path), image) {
                let name = path.display().to_string();
                slot.texture = Some(ctx.load_texture(name, image, TextureOptions::LINEAR));
            }
        }
        let modified = std::fs::metadata(path)
            .and_then(|file| file.modified())
            .ok();
        let known = self.thumbnails.get(path);
        let is_new = known.is_none_or(|known| known.modified != modified);
        if is_new && self.pending < MOST_PENDING {
            let texture = None;
            let slot = Thumbnail { modified, texture };
            self.thumbnails.insert(path.to_owned(), slot);
            let (sender, path, ctx) = (self.sender.clone(), path.to_owned(), ctx.clone());
            // Where the system starts no more threads there is no thumbnail.
            let begun = std::thread::Builder::new().spawn(move || {
                let image = read(&path);
                // The panel may be gone by now.
                let _ = sender.send((path, image));
                ctx.request_repaint();
            });
            self.pending += usize::from(begun.is_ok());
        }
        self.thumbnails.get(path)?.texture.as_ref()
    }
}

/// Larger files have no thumbnail.
const MAX_FILE: u64 = 1 << 30;

fn read(path: &Path) -> Option<ColorImage> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    let is_radiance = |e: &str| {
        ["hdr", "exr"]
            .iter()
            .any(|known| e.eq_ignore_ascii_case(known))
    };
    if ending.is_some_and(is_radiance) {
        let (image, _) = load_environment_image(&Disk, path).ok()?;
        return Some(panorama(&image));
    }
    let file = engine::input::read(path, MAX_FILE).ok()?;
    let image = image::ImageReader::new(std::io::Cursor::new(file));
    let image = image.with_guessed_format().ok()?.decode().ok()?;
    let small = image.thumbnail(THUMBNAIL, THUMBNAIL).to_rgba8();
    let size = [small.width() as usize, small.height() as usize];
    Some(ColorImage::from_rgba_unmultiplied(size, small.as_raw()))
}

/// A panorama in twice the width of its height, as bright as one looks at it.
fn panorama(image: &FloatImage) -> ColorImage {
    let (width, height) = (2 * THUMBNAIL, THUMBNAIL);
    let texel = |x: u32, y: u32| {
        // A few texels of each pixel: the sun may be missed, the rest is right.
        let at = |of: u32, among: u32, i: u32, size: u32| {
            ((f64::from(of) + (f64::from(i) + 0.5) / 4.0) / f64::from(among) * f64::from(size))
                as u32
        };
        let mut sum = [0.0f32; 3];
        for i in 0..16 {
            let u = at(x, width, i % 4, image.width).min(image.width - 1);
            let v = at(y, height, i / 4, image.height).min(image.height - 1);
            let rgb = image.rgb[(v * image.width + u) as usize];
            for (sum, channel) in sum.iter_mut().zip(rgb) {
                *sum += channel / 16.0;
            }
        }
        sum
    };
    let pixels = (0..width * height).map(|at| texel(at % width, at / width));
    let pixels: Vec<[f32; 3]> = pixels.collect();
    let total: f32 = pixels.iter().flatten().map(|x| x / (1.0 + x)).sum();
    let mean = (total / (3 * pixels.len()) as f32).clamp(1e-6, 0.99);
    let gain = 0.4 / (mean / (1.0 - mean));
    let shown = |[r, g, b]: [f32; 3]| {
        let channel = |x: f32| x * gain / (1.0 + x * gain);
        Color32::from(Rgba::from_rgb(channel(r), channel(g), channel(b)))
    };
    let size = [width as usize, height as usize];
    ColorImage::new(size, pixels.into_iter().map(shown).collect())
}

/// Shows the slot of an image; `folder` is what paths are relative to, `model` has the images of the model.
pub(crate) fn image_slot(
    ui: &mut Ui,
    slots: &mut ImageSlot,
    browser: &mut Browser,
    label: &str,
    folder: &Path,
    model: &[ModelImage],
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
            let thumbnail = match (file, file.strip_prefix(MODEL_IMAGE)) {
                ("", _) => None,
                (_, Some(name)) => {
                    let image = model.iter().find(|image| image.name == name);
                    image.map(|image| image.picture(ui.ctx()))
                }
                _ => slots.thumbnail(ui.ctx(), &folder.join(file)).cloned(),
            };
            let (place, _) = ui.allocate_exact_size(size, egui::Sense::hover());
            match thumbnail {
                Some(texture) => {
                    let own = texture.size_vec2();
                    let fitted = own * (size.x / own.max_elem());
                    let place = egui::Rect::from_center_size(place.center(), fitted);
                    egui::Image::new(&texture).paint_at(ui, place);
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
            let dropped = dropped_on(ui, field.rect.union(place));
            slots.has_taken |= dropped.is_some();
            if let Some(taken) = dropped.or(browsed) {
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
    if let Some(image) = taken_from_model(ui, &area.response) {
        value = Some(with_image(fields, &image));
    }
    Edited {
        response: area.response,
        value,
    }
}

/// An image of the model that was let go over a slot.
fn taken_from_model(ui: &Ui, slot: &Response) -> Option<Arc<DraggedImage>> {
    if slot.dnd_hover_payload::<DraggedImage>().is_some() {
        let stroke = Stroke::new(2.0, ui.visuals().selection.bg_fill);
        let painter = ui.painter();
        painter.rect_stroke(slot.rect, 2.0, stroke, StrokeKind::Inside);
    }
    slot.dnd_release_payload()
}

/// The slot with an image of the model, whose numbers aren't taken for colours.
fn with_image(fields: &[Field], image: &DraggedImage) -> Value {
    let file = Value::Text(format!("{MODEL_IMAGE}{}", image.name));
    let mut fields = fields.to_vec();
    if find(&fields, "file").is_none() {
        fields.insert(0, field("file", file.clone()));
    }
    if image.is_data && find(&fields, "color_space").is_none() {
        fields.push(field("color_space", Value::Text("linear".to_owned())));
    }
    with_key(&fields, "file", file)
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

/// The first image among the files that are dropped there. The others are not for a slot: the window knows what to do with a scene or an
/// environment.
fn dropped_on(ui: &Ui, place: egui::Rect) -> Option<PathBuf> {
    if !ui.rect_contains_pointer(place) {
        return None;
    }
    ui.input(|input| {
        let mut dropped = input.raw.dropped_files.iter().map(|file| file.path());
        dropped.find(|path| is_image(path)).map(Path::to_owned)
    })
}

/// Whether a file is an image, by its name.
pub(crate) fn is_image(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| {
        let mut known = ENDINGS.iter();
        known.any(|known| known.eq_ignore_ascii_case(ending))
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

    #[test]
    fn a_slot_takes_images_alone() {
        for name in ["a.png", "b.JPG", "c.d.webp"] {
            assert!(is_image(Path::new(name)), "{name}");
        }
        for name in [
            "a.hdr",
            "a.exr",
            "a.tga",
            "a.bmp",
            "a.glb",
            "a.look.toml",
            "a.wgsl",
            "png",
            "",
        ] {
            assert!(!is_image(Path::new(name)), "{name}");
        }
    }
}
