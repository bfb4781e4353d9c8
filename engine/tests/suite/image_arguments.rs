//! The images of `sam2D` parameters, read by a texture in the kernel that renders and compared with closed forms: wrap
//! modes, filters, colour space, size and mip levels. Skipped with a notice where there is no adapter.

use std::path::Path;

use ::device::Device;
use engine::procedural::{Procedural, TextureSources};
use engine::renderer::Renderer;
use engine::scene::look::Look;
use engine::scene::{Image, Material};
use tempfile::TempDir;

use crate::support::device;
use crate::support::scenes::{Shot, floor, from_above, render_textured, scene, settings, textured};

/// Pixels of a side of the pictures rendered here, each of which shows one read.
const SIDE: u32 = 16;

/// Pixel (x, y) reads the image at `start + step * (x, y)`. All samples of a pixel are the same.
const TEXTURES: &[(&str, &str)] = &[
    (
        "plain",
        "fn userProc(image: sam2D, start: vec2f, step: vec2f) -> vec4f {
            let pixel = floor((readAttr(WorldPos).xz + 1.0) * 8.0);
            return tex2D(image, start + step * pixel);
        }",
    ),
    (
        "alpha",
        "fn userProc(image: sam2D, start: vec2f, step: vec2f) -> vec4f {
            let pixel = floor((readAttr(WorldPos).xz + 1.0) * 8.0);
            return tex2D(image, start + step * pixel).aaaa;
        }",
    ),
    (
        "numbers",
        "/// @param image of numbers [data]
        fn userProc(image: sam2D, start: vec2f, step: vec2f) -> vec4f {
            let pixel = floor((readAttr(WorldPos).xz + 1.0) * 8.0);
            return tex2D(image, start + step * pixel);
        }",
    ),
    (
        "size",
        "fn userProc(image: sam2D) -> vec3f { return vec3f(texSize(image) / 100.0, 0.0); }",
    ),
    // The level goes up from row to row.
    (
        "levels",
        "fn userProc(image: sam2D, start: vec2f, step: vec2f, first: f32, each: f32) -> vec4f {
            let pixel = floor((readAttr(WorldPos).xz + 1.0) * 8.0);
            return tex2DLod(image, start + step * pixel, first + each * pixel.y);
        }",
    ),
];

/// A picture whose levels are computed straight from its bytes. Right for sizes where the share of a byte in a level
/// doesn't depend on the levels between: where each level but the first and the last is half the one above.
struct Picture {
    width: u32,
    height: u32,
    texels: Vec<[u8; 4]>,
}

impl Picture {
    /// Bytes without a pattern, dark ones among them.
    fn new(width: u32, height: u32) -> Self {
        let byte = |i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8;
        let texel = |i: u32| std::array::from_fn(|c| byte(4 * i + c as u32 + 1));
        Self {
            width,
            height,
            texels: (0..width * height).map(texel).collect(),
        }
    }

    fn save(&self, path: &Path) {
        let bytes = self.texels.as_flattened().to_vec();
        image::RgbaImage::from_raw(self.width, self.height, bytes)
            .expect("as many bytes as the picture has")
            .save(path)
            .expect("the picture is written");
    }

    fn level_size(&self, level: u32) -> [u32; 2] {
        [self.width, self.height].map(|side| (side >> level).max(1))
    }

    fn last_level(&self) -> u32 {
        self.width.max(self.height).ilog2()
    }

    /// One texel of a level.
    fn texel(&self, level: u32, x: u32, y: u32, srgb: bool) -> [f64; 4] {
        let [columns, rows] = self.level_size(level);
        let overlap = |i: u32, size: u32, at: u32, cells: u32| -> f64 {
            let scale = f64::from(size) / f64::from(cells);
            let [start, end] = [at, at + 1].map(|at| f64::from(at) * scale);
            (end.min(f64::from(i + 1)) - start.max(f64::from(i))).max(0.0) / scale
        };
        let mut sum = [0.0; 4];
        for (i, texel) in (0..).zip(&self.texels) {
            let share = overlap(i % self.width, self.width, x, columns)
                * overlap(i / self.width, self.height, y, rows);
            for (c, sum) in sum.iter_mut().enumerate() {
                let value = f64::from(texel[c]) / 255.0;
                let is_light = srgb && c < 3;
                *sum += share * if is_light { linear(value) } else { value };
            }
        }
        sum
    }

    /// What a level gives at uv.
    fn sample(&self, level: u32, [u, v]: [f64; 2], use_: &Use) -> [f64; 4] {
        let [columns, rows] = self.level_size(level);
        let at = [u * f64::from(columns), v * f64::from(rows)];
        let fetch = |x: i64, y: i64| {
            let [x, y] = [
                wrapped(x, columns, use_.wrap[0]),
                wrapped(y, rows, use_.wrap[1]),
            ];
            self.texel(level, x, y, use_.srgb)
        };
        if use_.nearest {
            return fetch(at[0].floor() as i64, at[1].floor() as i64);
        }
        let base = at.map(|t| (t - 0.5).floor());
        let [fx, fy] = [at[0] - 0.5 - base[0], at[1] - 0.5 - base[1]];
        let [x, y] = base.map(|t| t as i64);
        let row = |y: i64| mix(fetch(x, y), fetch(x + 1, y), fx);
        mix(row(y), row(y + 1), fy)
    }

    /// What `tex2DLod` gives.
    fn sample_between(&self, lod: f64, uv: [f64; 2], use_: &Use) -> [f64; 4] {
        let lod = lod.clamp(0.0, f64::from(self.last_level()));
        if use_.nearest {
            return self.sample((lod + 0.5).floor() as u32, uv, use_);
        }
        let fine = lod.floor() as u32;
        let coarse = (fine + 1).min(self.last_level());
        let [a, b] = [fine, coarse].map(|level| self.sample(level, uv, use_));
        mix(a, b, lod.fract())
    }
}

/// How a look uses a picture.
struct Use {
    wrap: [&'static str; 2],
    nearest: bool,
    srgb: bool,
}

impl Use {
    fn written(&self, path: &Path) -> String {
        let filter = if self.nearest { "nearest" } else { "linear" };
        let space = if self.srgb { "srgb" } else { "linear" };
        let path = path.display().to_string();
        let [u, v] = self.wrap;
        format!(
            "{{ file = {path:?}, color_space = '{space}', wrap = ['{u}', '{v}'], filter = '{filter}' }}"
        )
    }
}

fn linear(value: f64) -> f64 {
    match value <= 0.04045 {
        true => value / 12.92,
        false => ((value + 0.055) / 1.055).powf(2.4),
    }
}

fn wrapped(i: i64, size: u32, mode: &str) -> u32 {
    let size = i64::from(size);
    let i = match mode {
        "repeat" => i.rem_euclid(size),
        "mirror" => {
            let i = i.rem_euclid(2 * size);
            i.min(2 * size - 1 - i)
        }
        _ => i.clamp(0, size - 1),
    };
    i as u32
}

fn mix(a: [f64; 4], b: [f64; 4], t: f64) -> [f64; 4] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
}

fn sources() -> TextureSources {
    let mut sources = TextureSources::default();
    for (name, text) in TEXTURES {
        sources.insert(name, text);
    }
    sources
}

/// What each pixel shows, by rows.
fn shown(device: &Device, node: &str) -> Vec<[f32; 3]> {
    shown_with(device, node, &[])
}

/// The same with images of the model.
fn shown_with(device: &Device, node: &str, images: &[Image]) -> Vec<[f32; 3]> {
    let surface = Material {
        unlit: true,
        ..Material::default()
    };
    let mut scene = scene([(floor(1.0), surface)], glam::Vec3::ZERO);
    scene.images = images.to_vec();
    let look = format!("[node.image]\n{node}\n[material.'material 0']\nbase_color='image'\n");
    let procedural = textured(&mut scene, &look, &sources());
    let shot = Shot {
        size: (SIDE, SIDE),
        max_depth: 1,
        spp: 1,
    };
    render_textured(device, &scene, &procedural, &from_above(1.0, 1.0), shot).mean()
}

/// Compares what is shown with `expected(x, y)`, up to `error` in every channel.
#[track_caller]
fn assert_shows(
    name: &str,
    shown: &[[f32; 3]],
    error: f64,
    expected: impl Fn(f64, f64) -> [f64; 4],
) {
    for (i, shown) in (0..).zip(shown) {
        let (x, y) = (i % SIDE, i / SIDE);
        let expected = expected(f64::from(x), f64::from(y));
        for c in 0..3 {
            assert!(
                (f64::from(shown[c]) - expected[c]).abs() <= error,
                "{name}: pixel {x}, {y} shows {shown:?} instead of {expected:?}"
            );
        }
    }
}

/// Of decoding sRGB, and of weights in single precision. Graphics cards decode to within half a step of the encoded value (as Direct3D asks of
/// them), which is up to 1.14 steps of linear light where the curve is steepest; NVIDIA's are wrong by 0.7.
fn read_error(device: &Device) -> f64 {
    match device.gpu() {
        Some(_) => 1.15 / 255.0,
        None => 0.6 / 255.0,
    }
}

const START: [f64; 2] = [-1.47, -1.31];
const STEP: [f64; 2] = [0.231, 0.277];

fn uv(x: f64, y: f64) -> [f64; 2] {
    [START[0] + STEP[0] * x, START[1] + STEP[1] * y]
}

fn place() -> String {
    let [start, step] = [START, STEP].map(|v| format!("[{}, {}]", v[0], v[1]));
    format!("start={start}\nstep={step}")
}

const WRAPS: [[&str; 2]; 5] = [
    ["repeat", "repeat"],
    ["mirror", "mirror"],
    ["clamp", "clamp"],
    ["repeat", "clamp"],
    ["clamp", "mirror"],
];

fn saved(dir: &TempDir, name: &str, picture: &Picture) -> std::path::PathBuf {
    let path = dir.path().join(name);
    picture.save(&path);
    path
}

#[test]
fn wrap_filter_and_colour_space_are_chosen_for_each_use() {
    let Some(device) = device::open() else { return };
    let dir = tempfile::tempdir().expect("a temporary folder");
    let picture = Picture::new(5, 3);
    let path = saved(&dir, "a.png", &picture);
    for wrap in WRAPS {
        for (nearest, srgb) in [(false, true), (true, false)] {
            let use_ = Use {
                wrap,
                nearest,
                srgb,
            };
            let image = use_.written(&path);
            let shown = shown(
                &device,
                &format!("texture='plain'\nimage={image}\n{}", place()),
            );
            assert_shows(&image, &shown, read_error(&device), |x, y| {
                picture.sample(0, uv(x, y), &use_)
            });
        }
    }
}

#[test]
fn without_settings_colours_are_srgb_and_data_is_linear_and_alpha_always_is() {
    let Some(device) = device::open() else { return };
    let dir = tempfile::tempdir().expect("a temporary folder");
    let picture = Picture::new(4, 4);
    let path = saved(&dir, "a.png", &picture);
    let path = path.display();
    for (texture, srgb) in [("plain", true), ("numbers", false), ("alpha", true)] {
        let use_ = Use {
            wrap: ["repeat"; 2],
            nearest: false,
            srgb,
        };
        let node = format!("texture='{texture}'\nimage='{path}'\n{}", place());
        assert_shows(
            texture,
            &shown(&device, &node),
            read_error(&device),
            |x, y| {
                let value = picture.sample(0, uv(x, y), &use_);
                match texture {
                    "alpha" => [value[3]; 4],
                    _ => value,
                }
            },
        );
    }
}

#[test]
fn images_of_the_model_are_read_by_their_names() {
    let Some(device) = device::open() else { return };
    let picture = Picture::new(4, 4);
    // As a material reads it, in the other colour space.
    let image = Image {
        name: "image 3 \"maps/oak.png\"".to_owned(),
        width: 4,
        height: 4,
        rgba8: picture.texels.as_flattened().to_vec().into(),
        srgb: false,
    };
    for (space, srgb) in [("srgb", true), ("linear", false)] {
        let use_ = Use {
            wrap: ["repeat"; 2],
            nearest: false,
            srgb,
        };
        let file = format!("{{ file = 'model:maps/oak.png', color_space = '{space}' }}");
        let node = format!("texture='plain'\nimage={file}\n{}", place());
        let shown = shown_with(&device, &node, std::slice::from_ref(&image));
        assert_shows(space, &shown, read_error(&device), |x, y| {
            picture.sample(0, uv(x, y), &use_)
        });
    }
    let look = "[node.image]\ntexture='plain'\nimage='model:maps/oak.pmg'\n";
    let look = Look::parse(Path::new("a.look.toml"), look).expect("a look");
    let mut scene = scene([(floor(1.0), Material::default())], glam::Vec3::ZERO);
    scene.images = vec![image];
    let error = Procedural::build(&look, &mut scene, &sources()).expect_err("it has no such image");
    let error = error.to_string();
    assert!(error.contains("did you mean `maps/oak.png`?"), "{error}");
}

#[test]
fn size_is_that_of_the_full_image() {
    let Some(device) = device::open() else { return };
    let dir = tempfile::tempdir().expect("a temporary folder");
    let path = saved(&dir, "a.png", &Picture::new(37, 5));
    let node = format!("texture='size'\nimage='{}'", path.display());
    assert_shows("size", &shown(&device, &node), 1e-6, |_, _| {
        [0.37, 0.05, 0.0, 0.0]
    });
}

#[test]
fn levels_are_means_in_linear_light_and_mixed_between() {
    let Some(device) = device::open() else { return };
    let dir = tempfile::tempdir().expect("a temporary folder");
    for (width, height) in [(8, 4), (7, 5), (1, 6), (1, 1)] {
        let picture = Picture::new(width, height);
        let path = saved(&dir, "a.png", &picture);
        for (wrap, nearest, srgb) in [
            (["repeat"; 2], false, true),
            (["mirror"; 2], false, false),
            (["clamp"; 2], true, true),
        ] {
            let use_ = Use {
                wrap,
                nearest,
                srgb,
            };
            let image = use_.written(&path);
            let node = format!(
                "texture='levels'\nimage={image}\n{}\nfirst=-0.7\neach=0.3",
                place()
            );
            // A level's texels are rounded to 8 bits; those of sRGB are up to 2.3 times as far apart in linear light.
            let rounding = if srgb { 1.2 / 255.0 } else { 0.5 / 255.0 };
            let name = format!("{width} x {height}: {image}");
            assert_shows(
                &name,
                &shown(&device, &node),
                read_error(&device) + rounding,
                |x, y| picture.sample_between(-0.7 + 0.3 * y, uv(x, y), &use_),
            );
        }
    }
}

#[test]
fn only_images_whose_levels_are_read_have_them() {
    let Some(device) = device::open() else { return };
    let dir = tempfile::tempdir().expect("a temporary folder");
    // It fills a layer.
    let path = saved(&dir, "a.png", &Picture::new(64, 64));
    let bytes = |texture: &str| -> u64 {
        let mut scene = scene([(floor(1.0), Material::default())], glam::Vec3::ZERO);
        let look = format!(
            "[node.image]\ntexture='{texture}'\nimage='{}'\n[material.'material 0']\nbase_color='image'\n",
            path.display()
        );
        let procedural = textured(&mut scene, &look, &sources());
        let shot = Shot {
            size: (SIDE, SIDE),
            max_depth: 1,
            spp: 1,
        };
        let settings = settings(&from_above(1.0, 1.0), shot);
        let renderer = Renderer::new(&device, &scene, &procedural, &settings);
        let renderer = renderer.unwrap_or_else(|error| panic!("{error}"));
        let stats = renderer.stats().unwrap_or_else(|error| panic!("{error}"));
        let memory = stats.memory.into_iter();
        let layers = memory.filter(|(name, _)| name == "image layers");
        layers.map(|(_, bytes)| bytes).sum()
    };
    assert_eq!(bytes("plain"), 64 * 64 * 4);
    assert_eq!(bytes("levels"), 2 * 64 * 64 * 4);
}
