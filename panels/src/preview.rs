//! Small pictures of nodes: each is evaluated on a square of one metre, on a device and a thread of its own.
//!
//! A picture is known by what it shows: the node, all below it, and the texts of their textures. While a new one is made
//! the former stays.

use std::collections::{BTreeSet, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use device::{Device, DeviceError};
use egui::{Color32, ColorImage, Rgba, TextureHandle, TextureOptions};
use engine::evaluate::{Evaluator, Point};
use engine::isolated::{Isolated, Subject};
use engine::procedural::TextureSources;
use engine::scene::look::{Look, Value};
use engine::session::{Document, summary};
use texgen::OutputType;

use crate::Textures;
use crate::model::Model;

/// Points along a side of a picture.
const SIZE: usize = 64;
/// Kernels that are kept: one for each set of textures.
const MAX_KERNELS: usize = 16;

/// What is to be shown: a node, or without a look a texture of the library with its own values.
struct Wanted {
    node: String,
    hash: u64,
    look: Option<Arc<Look>>,
    sources: Arc<TextureSources>,
}

/// What it looks like, or why it can't be shown.
struct Made {
    node: String,
    is_texture: bool,
    hash: u64,
    picture: Result<ColorImage, String>,
}

/// Pictures of the nodes of a look.
pub struct Previews {
    wanted: Sender<Wanted>,
    made: Receiver<Made>,
    pictures: HashMap<String, Picture>,
    /// Of textures, by their names.
    textures: HashMap<String, Picture>,
    /// The look that is shown, with the hashes of its nodes so far.
    shown: Option<Shown>,
}

#[derive(Default)]
struct Picture {
    /// What was asked for last.
    asked: Option<u64>,
    texture: Option<TextureHandle>,
    error: Option<String>,
}

struct Shown {
    revision: u64,
    look: Arc<Look>,
    textures: Arc<texgen::Library>,
    sources: Arc<TextureSources>,
    hashes: HashMap<String, u64>,
}

impl std::fmt::Debug for Previews {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Previews").finish_non_exhaustive()
    }
}

impl Previews {
    /// Starts the thread; `open` is called there. Where it fails, there are no pictures. It should open a device of its
    /// own, so that the renderer's isn't kept waiting.
    pub fn start(
        ctx: &egui::Context,
        open: impl FnOnce() -> Result<Device, DeviceError> + Send + 'static,
    ) -> Self {
        let (wanted, requests) = channel();
        let (results, made) = channel();
        let ctx = ctx.clone();
        // It ends when the panel is gone, and with it the sender.
        let work = move || work(&ctx, open, &requests, &results);
        // A system that starts no more threads leaves the nodes without pictures.
        let _ = std::thread::Builder::new()
            .name("previews".to_owned())
            .spawn(work);
        Self {
            wanted,
            made,
            pictures: HashMap::new(),
            textures: HashMap::new(),
            shown: None,
        }
    }

    /// The picture of a node, as far as there is one; else why there is none, where that is known.
    pub(crate) fn picture(
        &mut self,
        ctx: &egui::Context,
        document: &Document,
        textures: &Textures,
        model: &Model,
        node: &str,
    ) -> (Option<&TextureHandle>, Option<&str>) {
        self.receive(ctx);
        let is_shown = self.shown.as_ref().is_some_and(|shown| {
            shown.revision == document.revision() && Arc::ptr_eq(&shown.textures, &textures.library)
        });
        if !is_shown {
            self.shown = Some(Shown {
                revision: document.revision(),
                look: Arc::new(document.look().clone()),
                textures: Arc::clone(&textures.library),
                sources: Arc::new(textures.sources.clone()),
                hashes: HashMap::new(),
            });
        }
        let shown = self.shown.as_mut().expect("it was set above");
        let hash = hash_of(shown, model, node);
        let picture = self.pictures.entry(node.to_owned()).or_default();
        if picture.asked != Some(hash) {
            picture.asked = Some(hash);
            // Without a device nobody listens.
            let _ = self.wanted.send(Wanted {
                node: node.to_owned(),
                hash,
                look: Some(Arc::clone(&shown.look)),
                sources: Arc::clone(&shown.sources),
            });
        }
        (picture.texture.as_ref(), picture.error.as_deref())
    }

    /// The picture of a texture with its own values, once there is one.
    pub(crate) fn texture(
        &mut self,
        ctx: &egui::Context,
        textures: &Textures,
        name: &str,
    ) -> Option<&TextureHandle> {
        self.receive(ctx);
        let mut hasher = DefaultHasher::new();
        let text = textures
            .library
            .get(name)
            .map(|texture| texture.file().text());
        text.hash(&mut hasher);
        let hash = hasher.finish();
        let picture = self.textures.entry(name.to_owned()).or_default();
        if picture.asked != Some(hash) {
            picture.asked = Some(hash);
            // Without a device nobody listens.
            let _ = self.wanted.send(Wanted {
                node: name.to_owned(),
                hash,
                look: None,
                sources: Arc::new(textures.sources.clone()),
            });
        }
        picture.texture.as_ref()
    }

    fn receive(&mut self, ctx: &egui::Context) {
        while let Ok(Made {
            node,
            is_texture,
            hash,
            picture: made,
        }) = self.made.try_recv()
        {
            let known = match is_texture {
                true => &mut self.textures,
                false => &mut self.pictures,
            };
            let Some(picture) = known.get_mut(&node) else {
                continue;
            };
            match made {
                Ok(image) => {
                    let options = TextureOptions::LINEAR;
                    match &mut picture.texture {
                        Some(texture) => texture.set(image, options),
                        None => picture.texture = Some(ctx.load_texture(&node, image, options)),
                    }
                    picture.error = None;
                }
                Err(error) if picture.asked == Some(hash) => picture.error = Some(error),
                Err(_) => {}
            }
        }
    }
}

/// Of a node and all below it.
fn hash_of(shown: &mut Shown, model: &Model, node: &str) -> u64 {
    if let Some(&hash) = shown.hashes.get(node) {
        return hash;
    }
    let below = model.upstream(node);
    let mut hasher = DefaultHasher::new();
    node.hash(&mut hasher);
    for table in &shown.look.nodes {
        if !below.contains(table.name.value.as_str()) {
            continue;
        }
        table.name.value.hash(&mut hasher);
        for field in &table.params {
            field.key.value.hash(&mut hasher);
            hash_value(&field.value.value, &mut hasher);
        }
        let texture = shown.textures.get(&table.texture.value);
        texture
            .map(|texture| texture.file().text())
            .hash(&mut hasher);
    }
    let hash = hasher.finish();
    shown.hashes.insert(node.to_owned(), hash);
    hash
}

/// A value without its place in the text.
fn hash_value(value: &Value, hasher: &mut DefaultHasher) {
    std::mem::discriminant(value).hash(hasher);
    match value {
        Value::Bool(b) => b.hash(hasher),
        Value::Integer(i) => i.hash(hasher),
        Value::Float(f) => f.to_bits().hash(hasher),
        Value::Text(text) => text.hash(hasher),
        Value::List(items) => items
            .iter()
            .for_each(|item| hash_value(&item.value, hasher)),
        Value::Table(fields) => {
            for field in fields {
                field.key.value.hash(hasher);
                hash_value(&field.value.value, hasher);
            }
        }
        Value::Date => {}
    }
}

/// The thread's work.
fn work(
    ctx: &egui::Context,
    open: impl FnOnce() -> Result<Device, DeviceError>,
    requests: &Receiver<Wanted>,
    results: &Sender<Made>,
) {
    let Ok(device) = open() else {
        return;
    };
    let mut kernels: Vec<(BTreeSet<String>, Evaluator)> = Vec::new();
    while let Ok(first) = requests.recv() {
        // While a slider is dragged, only the last of each node matters.
        let mut waiting: Vec<Wanted> = Vec::new();
        for wanted in std::iter::once(first).chain(requests.try_iter()) {
            let is_same = |other: &Wanted| {
                other.node == wanted.node && other.look.is_some() == wanted.look.is_some()
            };
            waiting.retain(|other| !is_same(other));
            waiting.push(wanted);
        }
        for wanted in waiting {
            let picture = picture(&device, &mut kernels, &wanted);
            let Wanted {
                node, hash, look, ..
            } = wanted;
            let made = Made {
                node,
                is_texture: look.is_none(),
                hash,
                picture,
            };
            if results.send(made).is_err() {
                return;
            }
            ctx.request_repaint();
        }
    }
}

fn picture(
    device: &Device,
    kernels: &mut Vec<(BTreeSet<String>, Evaluator)>,
    wanted: &Wanted,
) -> Result<ColorImage, String> {
    let subject = match &wanted.look {
        Some(look) => Subject::Node(&wanted.node, look),
        None => Subject::Texture(&wanted.node),
    };
    let isolated = Isolated::new(subject, &wanted.sources).map_err(|p| summary(&p))?;
    let output = isolated.output();
    let library = isolated.procedural().graph().library();
    let names = library.textures().iter().map(|t| t.name().to_owned());
    let names: BTreeSet<String> = names.collect();
    let evaluator = match kernels.iter().position(|(known, _)| *known == names) {
        Some(place) => {
            let mut kernel = kernels.remove(place);
            kernel.1.replace(isolated);
            kernels.push(kernel);
            kernels.last_mut()
        }
        None => {
            if kernels.len() >= MAX_KERNELS {
                kernels.remove(0);
            }
            kernels.push((names, Evaluator::new(device, isolated)));
            kernels.last_mut()
        }
    };
    let (_, evaluator) = evaluator.expect("one was added");
    let values = evaluator.evaluate(&square());
    let values = values.map_err(|error| error.to_string())?;
    let pixels = values.into_iter().map(|value| shown(value, output));
    Ok(ColorImage::new([SIZE, SIZE], pixels.collect()))
}

/// Points of a square of one metre around the origin that faces +Z, row by row from the upper left.
fn square() -> Vec<Point> {
    let points = (0..SIZE * SIZE).map(|i| {
        let u = ((i % SIZE) as f32 + 0.5) / SIZE as f32;
        let v = ((i / SIZE) as f32 + 0.5) / SIZE as f32;
        Point::new()
            .with("WorldPos", &[u - 0.5, 0.5 - v, 0.0])
            .with("TexCoord0", &[u, v])
            .with("Normal", &[0.0, 0.0, 1.0])
            .with("Footprint", &[1.0 / SIZE as f32])
    });
    points.collect()
}

/// Numbers are grey, vectors colours.
fn shown(value: [f32; 4], output: OutputType) -> Color32 {
    let [x, y, z, _] = value;
    let rgb = match output {
        OutputType::F32 => [x; 3],
        OutputType::Vec2 => [x, y, 0.0],
        OutputType::Vec3 | OutputType::Vec4 => [x, y, z],
    };
    // What isn't a number is black.
    let [r, g, b] = rgb.map(|x| if x > 0.0 { x.min(1.0) } else { 0.0 });
    Rgba::from_rgb(r, g, b).into()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const LOOK: &str = "[node.a]\ntexture = 'ramp'\n[node.b]\ntexture = 'tint'\nx = 'a'\nred = 0.5\n\
                        [node.c]\ntexture = 'tint'\nx = 'gone'\n";

    fn textures() -> Textures {
        let mut sources = TextureSources::default();
        sources.insert(
            "ramp",
            "fn userProc() -> f32 { return readAttr(TexCoord0).x; }",
        );
        sources.insert(
            "tint",
            "fn userProc(x: f32, red: f32) -> vec3f { return vec3f(red, x, 0.0); }",
        );
        Textures::load(&sources)
    }

    fn document(text: &str) -> Document {
        Document::new(Path::new("a"), text).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn a_picture_is_known_by_what_is_below_it() {
        let textures = textures();
        let hashes = |text: &str| {
            let document = document(text);
            let model = Model::new(&document, &textures.library);
            let mut shown = Shown {
                revision: 0,
                look: Arc::new(document.look().clone()),
                textures: Arc::clone(&textures.library),
                sources: Arc::new(textures.sources.clone()),
                hashes: HashMap::new(),
            };
            ["a", "b", "c"].map(|node| hash_of(&mut shown, &model, node))
        };
        let [a, b, c] = hashes(LOOK);
        assert_eq!(hashes(&format!("# moved\n{LOOK}")), [a, b, c]);
        let [same_a, other_b, same_c] = hashes(&LOOK.replace("0.5", "0.6"));
        assert_eq!((a, c), (same_a, same_c));
        assert_ne!(b, other_b);
    }

    #[test]
    fn values_are_changed_without_a_kernel() {
        let Ok(device) = Device::best() else {
            eprintln!("skipped: there is no device");
            return;
        };
        let textures = textures();
        let mut kernels = Vec::new();
        let mut make = |node: &str, text: &str| {
            let wanted = Wanted {
                node: node.to_owned(),
                hash: 0,
                look: Some(Arc::new(document(text).look().clone())),
                sources: Arc::new(textures.sources.clone()),
            };
            picture(&device, &mut kernels, &wanted)
        };
        let first = make("b", LOOK).expect("a picture");
        let (left, right) = (first.pixels[0], first.pixels[SIZE - 1]);
        assert!(left.g() < 60 && right.g() > 250 && left.b() == 0);
        let made = device.counts().pipelines;
        let second = make("b", &LOOK.replace("0.5", "0.0")).expect("a picture");
        assert_eq!(device.counts().pipelines, made);
        assert_eq!(second.pixels[0].r(), 0);
        assert_eq!(second.pixels[9].g(), first.pixels[9].g());
        assert!(make("c", LOOK).is_err());
        let by_itself = Wanted {
            node: "ramp".to_owned(),
            hash: 0,
            look: None,
            sources: Arc::new(textures.sources.clone()),
        };
        let by_itself = picture(&device, &mut kernels, &by_itself).expect("a picture");
        assert!(by_itself.pixels[0].r() < 60 && by_itself.pixels[SIZE - 1].r() > 250);
    }
}
