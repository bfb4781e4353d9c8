//! Inputs to begin with: made here, or the project's own examples; and those that lie beside the checkout, where they do.

mod pictures;
mod scenes;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use engine::film::{Film, Layers, Origin, Part, unpacked};

use crate::mutate::SEPARATOR;
use crate::root;

pub use pictures::panoramas;
pub use scenes::{gltf, triangle};

/// A texture with what the shipped ones lack.
pub const RICH: &str = "alias Real = f32;
const N = 3;
struct Wave { amplitude: Real, phase: vec2f, rows: array<f32, N> }
fn add(w: ptr<function, Wave>, amount: Real) -> Wave {
    (*w).amplitude += amount;
    for (var i = 0; i < N; i++) { w.rows[i] += amount; if w.rows[i] > 9.0 { return *w; } }
    return *w;
}
fn spin(x: Real) -> array<Real, N> {
    var a = array<Real, N>(x, x, x);
    loop { a[1] += 1.0; if a[1] > x { break; } continuing { a[2] -= 0.5; break if a[2] < 0.0; } }
    while a[0] < 3.0 { a[0] += 1.0; switch i32(a[0]) { case 1: { continue; } case 2, N: { return a; } default: { } } }
    return a;
}
/// @param list = [1, 2, 3]
fn userProc(image: sam2D, ramp: ramp1D, list: array<f32, N>, points: array<vec3f, 2>, m: mat3x3f, n: i32, on: bool) -> vec4f {
    var w = Wave(1.0, readAttr(TexCoord0).xy, list);
    let p = &w;
    let added = add(p, list[n]);
    let i = spin(added.amplitude)[1] + points[1].x;
    if on { return tex2D(image, w.phase) + readAttr(_WETNESS); }
    return rampEval(ramp, i) * vec4f(m * points[n], readGlobal(Time).x) + readAttr(AO);
}
";
/// Looks that need nothing but the scene, for the target `render`.
const PLAIN_LOOKS: [&str; 3] = [
    "environment = { color = [0.5, 0.6, 0.7] }\n[material.A]\nbase_color = [0.8, 0.2, 0.1]\nroughness = 0.3\nmetallic = 1.0\n",
    "[camera]\nposition = [0.5, 1.0, 4.0]\nlook_at = [0.0, 0.0, 0.0]\n[material.A]\ntransmission = 0.9\nior = 1.5\n",
    "environment = { sky = { sun_elevation = 30.0 } }\n[material.A]\nemission = [1, 2, 3]\nopacity = 0.5\n",
];

/// Every file with one of the extensions, at most `largest` bytes long; nothing where there is no such folder.
fn files(folder: &Path, extensions: &[&str], largest: u64) -> Vec<Vec<u8>> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        for path in entries.map(|entry| entry.path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path
                .extension()
                .and_then(|e| e.to_str())
                .is_some_and(|e| extensions.contains(&e))
                && path.metadata().is_ok_and(|meta| meta.len() <= largest)
            {
                found.push(path);
            }
        }
    }
    found.sort();
    found
        .iter()
        .filter_map(|path| fs::read(path).ok())
        .collect()
}

/// Looks of the documentation and of the examples.
pub fn looks() -> Vec<Vec<u8>> {
    let text = fs::read_to_string(root().join("docs/look-file.md")).expect("part of the project");
    let blocks = text.split("```toml\n").skip(1);
    let blocks = blocks.filter_map(|rest| rest.split("```").next());
    let mut looks: Vec<Vec<u8>> = blocks.map(|block| block.as_bytes().to_vec()).collect();
    looks.extend(PLAIN_LOOKS.map(|look| look.as_bytes().to_vec()));
    looks.extend(files(&root().join("examples"), &["toml"], 1 << 16));
    looks
}

/// The standard textures and [`RICH`], which is there several times because it has most to change.
pub fn textures() -> Vec<Vec<u8>> {
    let mut textures = files(&root().join("user_textures"), &["wgsl"], 1 << 16);
    textures.extend([RICH; 3].map(|text| text.as_bytes().to_vec()));
    textures.extend(files(
        &root().join("../shared/trials/language"),
        &["wgsl"],
        1 << 12,
    ));
    textures
}

/// Partial renders.
pub fn films() -> Vec<Vec<u8>> {
    let film = |size: (u32, u32), samples: std::ops::Range<u32>, missing: bool| {
        let mut film = Film::new(size.0, size.1);
        for sample in samples.clone() {
            for pixel in 0..film.pixels() {
                if !(missing && pixel > 0 && sample + 1 == samples.end) {
                    let value = ((sample + 1) as f32 * (pixel + 1) as f32).sin() * 1e3;
                    film.add_sample(pixel, [value, value * 1e-6, value * 1e6]);
                }
            }
        }
        let origin = Origin {
            device: "llvmpipe".to_owned(),
            scene: "scene.glb".to_owned(),
            names: BTreeMap::new(),
            look: missing.then(|| "scene.look.toml".to_owned()),
            settings: vec![
                ("seed".to_owned(), "0".to_owned()),
                ("size".to_owned(), format!("{}x{}", size.0, size.1)),
            ],
        };
        Part::new(film, samples, origin)
    };
    let mut both = film((2, 2), 0..2, false);
    both.merge(&film((2, 2), 5..9, false)).expect("they fit");
    let layers = Layers::named(["depth", "normal"]).expect("there are such layers");
    let mut seen = Film::with_layers(2, 2, layers);
    for pixel in 0..3 {
        seen.add_sample(pixel, [0.5; 3]);
        seen.add_surface(pixel, 7, |_| [pixel as f32, -0.25, 1e3]);
    }
    seen.add_sample(3, [0.25; 3]);
    let seen = Part::new(seen, 7..8, both.origin.clone());
    let one = film((1, 1), 0..1, false);
    let packed = [one, film((3, 2), 4..9, true), both, seen].map(|part| {
        let mut bytes = Vec::new();
        part.write(&mut bytes).expect("memory takes everything");
        bytes
    });
    // Hardly a change of what is packed can be unpacked; the form without that is read by the same code.
    let plain = packed.iter().filter_map(|file| unpacked(file));
    plain.chain(packed.clone()).collect()
}

/// Scenes with and without looks, for the target `render`.
pub fn scenes() -> Vec<Vec<u8>> {
    let scenes = scenes::renderable();
    let mut inputs = Vec::new();
    for (number, scene) in scenes.into_iter().enumerate() {
        let look = PLAIN_LOOKS[number % PLAIN_LOOKS.len()].as_bytes();
        inputs.push([&scene[..], SEPARATOR, look].concat());
        inputs.push(scene);
    }
    inputs
}
