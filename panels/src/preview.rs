//! Small pictures of nodes: each is evaluated on a square of one metre, on a device and a thread of its own.
//!
//! A picture is known by what it shows: the node, all below it, the texts of their textures, and the images that they read. While a new one
//! is made the former stays.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use device::{Device, DeviceError};
use egui::{Color32, ColorImage, Rgba, TextureHandle, TextureOptions};
use engine::evaluate::{Evaluator, Point};
use engine::isolated::{Isolated, Subject};
use engine::procedural::TextureSources;
use engine::scene::Image;
use engine::scene::look::{Look, MODEL_IMAGE, NodeLook, Value, find};
use engine::session::{Document, summary};
use texgen::{Library, OutputType, ParameterType, TextureType};

use crate::Textures;
use crate::model::Model;
use crate::model_image::ModelImage;

/// Points along a side of a picture.
const SIZE: usize = 64;
/// Kernels that are kept: one for each set of textures.
const MAX_KERNELS: usize = 16;
/// Seconds after which files of images are looked at again.
const FILES: f64 = 1.0;

/// What is to be shown: a node, or without a look a texture of the library with its own values.
struct Wanted {
    node: String,
    hash: u64,
    look: Option<Arc<Look>>,
    sources: Arc<TextureSources>,
    /// Those of the model that are read.
    images: Vec<Image>,
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
    textures: Arc<Library>,
    sources: Arc<TextureSources>,
    /// Of all images of the model.
    images: u64,
    /// When the first of the hashes was made, seconds.
    since: f64,
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
        images: &[ModelImage],
        model: &Model,
        node: &str,
    ) -> (Option<&TextureHandle>, Option<&str>) {
        self.receive(ctx);
        let is_shown = self.shown.as_ref().is_some_and(|shown| {
            shown.revision == document.revision() && Arc::ptr_eq(&shown.textures, &textures.library)
        });
        if !is_shown {
            self.shown = Some(Shown::new(document, textures));
        }
        let shown = self.shown.as_mut().expect("it was set above");
        shown.renew(images, ctx.input(|input| input.time));
        let hash = hash_of(shown, images, model, node);
        let picture = self.pictures.entry(node.to_owned()).or_default();
        // While a scene goes and another one comes, its images are not there: it is asked for then.
        if picture.asked != Some(hash)
            && let Some(images) = images_of(shown, images, model, node)
        {
            picture.asked = Some(hash);
            // Without a device nobody listens.
            let _ = self.wanted.send(Wanted {
                node: node.to_owned(),
                hash,
                look: Some(Arc::clone(&shown.look)),
                sources: Arc::clone(&shown.sources),
                images,
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
        hash_texture(textures.library.get(name), &mut hasher);
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
                images: Vec::new(),
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

impl Shown {
    fn new(document: &Document, textures: &Textures) -> Self {
        Self {
            revision: document.revision(),
            look: Arc::new(document.look().clone()),
            textures: Arc::clone(&textures.library),
            sources: Arc::new(textures.sources.clone()),
            images: 0,
            since: f64::NEG_INFINITY,
            hashes: HashMap::new(),
        }
    }

    /// Forgets hashes that may be of other images than those of now.
    fn renew(&mut self, images: &[ModelImage], now: f64) {
        let mut hasher = DefaultHasher::new();
        (images.iter()).for_each(|image| image.stamp().hash(&mut hasher));
        let images = hasher.finish();
        if self.images != images || now - self.since >= FILES {
            self.images = images;
            self.since = now;
            self.hashes.clear();
        }
    }
}

/// The files that a node reads images from, as the look names them.
fn files<'l>(table: &'l NodeLook, textures: &'l Library) -> impl Iterator<Item = &'l str> {
    let texture = textures.get(&table.texture.value);
    let parameters = texture.map(|texture| texture.parameters());
    let parameters = parameters.unwrap_or_default();
    let images = table.params.iter().filter(move |field| {
        let mut parameters = parameters.iter();
        parameters.any(|p| p.ty == ParameterType::Image && p.name == field.key.value)
    });
    images.filter_map(|field| match &field.value.value {
        Value::Text(file) => Some(file.as_str()),
        Value::Table(fields) => match &find(fields, "file")?.value {
            Value::Text(file) => Some(file.as_str()),
            _ => None,
        },
        _ => None,
    })
}

/// The images of the model that a node and all below it read; `None` where the scene that has them is gone.
fn images_of(
    shown: &Shown,
    images: &[ModelImage],
    model: &Model,
    node: &str,
) -> Option<Vec<Image>> {
    let below = model.upstream(node);
    let tables = shown.look.nodes.iter();
    let tables = tables.filter(|table| below.contains(table.name.value.as_str()));
    let names = tables.flat_map(|table| files(table, &shown.textures));
    let names: HashSet<&str> = names
        .filter_map(|file| file.strip_prefix(MODEL_IMAGE))
        .collect();
    let images = images.iter();
    let read = images.filter(|image| names.contains(image.name.as_str()));
    read.map(ModelImage::whole).collect()
}

/// Of a node and all below it.
fn hash_of(shown: &mut Shown, images: &[ModelImage], model: &Model, node: &str) -> u64 {
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
        hash_texture(shown.textures.get(&table.texture.value), &mut hasher);
        for file in files(table, &shown.textures) {
            match file.strip_prefix(MODEL_IMAGE) {
                Some(name) => images
                    .iter()
                    .filter(|image| image.name == name)
                    .for_each(|image| image.stamp().hash(&mut hasher)),
                None => {
                    let file = std::fs::metadata(shown.look.resolve(file)).ok();
                    let written = file.map(|file| (file.modified().ok(), file.len()));
                    written.hash(&mut hasher);
                }
            }
        }
    }
    let hash = hasher.finish();
    shown.hashes.insert(node.to_owned(), hash);
    hash
}

/// What a texture is made of, with the shared files that it uses.
fn hash_texture(texture: Option<&TextureType>, hasher: &mut DefaultHasher) {
    let Some(file) = texture.map(TextureType::file) else {
        return;
    };
    file.text().hash(hasher);
    for library in file.libraries() {
        library.name().hash(hasher);
        library.text().hash(hasher);
    }
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
    let isolated = Isolated::with_images(subject, &wanted.sources, &wanted.images);
    let isolated = isolated.map_err(|problems| summary(&problems))?;
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

    use texgen::SourceFile;

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
        sources.insert(
            "map",
            "fn userProc(file: sam2D) -> vec4f { return tex2D(file, readAttr(TexCoord0).xy); }",
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
            let mut shown = Shown::new(&document, &textures);
            ["a", "b", "c"].map(|node| hash_of(&mut shown, &[], &model, node))
        };
        let [a, b, c] = hashes(LOOK);
        assert_eq!(hashes(&format!("# moved\n{LOOK}")), [a, b, c]);
        let [same_a, other_b, same_c] = hashes(&LOOK.replace("0.5", "0.6"));
        assert_eq!((a, c), (same_a, same_c));
        assert_ne!(b, other_b);
    }

    #[test]
    fn a_picture_is_made_anew_when_a_shared_file_changes() {
        let textures = |half: &str| {
            let shared = format!("fn lessen(x: f32) -> f32 {{ return {half}; }}");
            let shared = SourceFile::new("lessening", "lib/lessening.wgsl", shared);
            let text = "/// @use lessening\nfn userProc(x: f32) -> f32 { return lessen(x); }";
            let file = SourceFile::new("halved", "halved.wgsl", text);
            let mut sources = TextureSources::default();
            sources.insert_file(file.with_libraries(vec![shared]));
            sources.insert("plain", "fn userProc() -> f32 { return 0.5; }");
            let textures = Textures::load(&sources);
            assert!(textures.broken.is_empty(), "{:?}", textures.broken);
            textures
        };
        let look = "[node.a]\ntexture = 'halved'\n[node.b]\ntexture = 'halved'\nx = 'a'\n\
                    [node.c]\ntexture = 'plain'\n";
        let hashes = |textures: &Textures| {
            let document = document(look);
            let model = Model::new(&document, &textures.library);
            let mut shown = Shown::new(&document, textures);
            let nodes = ["a", "b", "c"].map(|node| hash_of(&mut shown, &[], &model, node));
            let by_itself = |name: &str| {
                let mut hasher = DefaultHasher::new();
                hash_texture(textures.library.get(name), &mut hasher);
                hasher.finish()
            };
            (nodes, ["halved", "plain"].map(by_itself))
        };
        let ([a, b, c], [halved, plain]) = hashes(&textures("0.5 * x"));
        assert_eq!(hashes(&textures("0.5 * x")), ([a, b, c], [halved, plain]));
        let ([other_a, other_b, same_c], [other_halved, same_plain]) = hashes(&textures("x / 2.0"));
        assert!(other_a != a && other_b != b && other_halved != halved);
        assert_eq!((same_c, same_plain), (c, plain));
    }

    const MAPS: &str = "[node.a]\ntexture = 'map'\nfile = 'model:t.png'\n\
                        [node.b]\ntexture = 'map'\nfile = { file = 't.png', filter = 'nearest' }\n\
                        [node.c]\ntexture = 'tint'\nx = 'b.x'\n";

    fn image(name: &str, red: u8) -> Image {
        Image {
            name: format!("image \"{name}\""),
            width: 1,
            height: 1,
            rgba8: Arc::new(vec![red, 0, 0, 255]),
            srgb: true,
        }
    }

    #[test]
    fn a_picture_is_made_anew_when_an_image_changes() {
        let textures = textures();
        let folder = tempfile::tempdir().expect("a folder");
        let look = folder.path().join("a.look.toml");
        let document = Document::new(&look, MAPS).expect("a look");
        let model = Model::new(&document, &textures.library);
        let mut shown = Shown::new(&document, &textures);
        let mut hashes = |red: u8, now: f64| {
            let images = [("t.png", red), ("other.png", 0)];
            let images = images.map(|(name, red)| ModelImage::new(&image(name, red)));
            shown.renew(&images, now);
            ["a", "b", "c"].map(|node| hash_of(&mut shown, &images, &model, node))
        };
        let [a, b, c] = hashes(1, 0.0);
        let [other_a, same_b, same_c] = hashes(2, 0.0);
        assert_ne!(a, other_a);
        assert_eq!([b, c], [same_b, same_c]);
        // Files are looked at once in a while.
        std::fs::write(folder.path().join("t.png"), "not much").expect("a file");
        assert_eq!(hashes(2, 0.5), [other_a, b, c]);
        let [same_a, there_b, there_c] = hashes(2, 1.5);
        assert_eq!(same_a, other_a);
        assert!(there_b != b && there_c != c);
        std::fs::write(folder.path().join("t.png"), "something else").expect("a file");
        let [_, changed_b, changed_c] = hashes(2, 3.0);
        assert!(changed_b != there_b && changed_c != there_c);
        assert_eq!(hashes(2, 4.5), [other_a, changed_b, changed_c]);
    }

    #[test]
    fn images_of_the_model_are_handed_to_the_nodes_that_read_them() {
        let textures = textures();
        let document = document(MAPS);
        let model = Model::new(&document, &textures.library);
        let shown = Shown::new(&document, &textures);
        let whole = [image("t.png", 200), image("other.png", 0)];
        let small = whole.each_ref().map(ModelImage::new);
        let read = |node: &str| images_of(&shown, &small, &model, node);
        let images = read("a").expect("the scene is there");
        let names: Vec<&str> = images.iter().map(Image::short_name).collect();
        assert_eq!(names, ["t.png"]);
        assert!(read("b").is_some_and(|images| images.is_empty()));
        if let Ok(device) = Device::best() {
            let wanted = Wanted {
                node: "a".to_owned(),
                hash: 0,
                look: Some(Arc::clone(&shown.look)),
                sources: Arc::clone(&shown.sources),
                images: images.clone(),
            };
            let made = picture(&device, &mut Vec::new(), &wanted).expect("a picture");
            let [red, green, _, _] = made.pixels[0].to_array();
            assert!(red.abs_diff(200) <= 2 && green == 0, "{red} {green}");
        } else {
            eprintln!("skipped in part: there is no device");
        }
        drop((images, whole));
        assert!(read("a").is_none(), "nothing keeps the scene's pixels");
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
                images: Vec::new(),
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
            images: Vec::new(),
        };
        let by_itself = picture(&device, &mut kernels, &by_itself).expect("a picture");
        assert!(by_itself.pixels[0].r() < 60 && by_itself.pixels[SIZE - 1].r() > 250);
    }
}
