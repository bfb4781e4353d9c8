//! The standard textures fade what is finer than the pixel into its mean: from afar one sample a pixel shows the mean
//! instead of noise, from near nothing is lost. Skipped with a notice where there is no adapter.

use ::device::Device;
use engine::procedural::TextureSources;
use engine::scene::{Material, Projection};
use glam::Vec3;

use crate::support::device;
use crate::support::root;
use crate::support::scenes::{Shot, camera, quad, render_textured, scene, textured};

/// Pixels of a side of the picture.
const SIDE: u32 = 64;
/// Half of the side of what is seen at the origin, metres.
const SEEN: f32 = 1.0;
/// Side of the plane, metres: one unit of uv.
const PLANE: f32 = 3.0;
/// Height of the camera above the origin, metres.
const HEIGHT: f32 = 10.0;
/// Most that a pixel may be off where the pattern has faded, in standard deviations of the pattern: one sample a pixel is
/// then better than four hundred of the pattern itself, whose noise falls with the root of their number. What is left
/// is no noise but how well the pattern's mean is known, and of a checkerboard the edge of a square: 1 / 7.3 squared.
const BAND: f64 = 0.05;
/// Features of a pattern in a pixel far away. No round number, or samples might meet the pattern at the same places.
const FAR: f32 = 7.3;

/// How textures say the width of a pixel, and what makes it nothing.
const WIDTHS: [(&str, &str); 2] = [("texcoord.w", "0.0"), ("position.w", "0.0")];

/// A texture from `user_textures` in a use of it.
struct Case {
    texture: &'static str,
    /// What of its result is looked at.
    swizzle: &'static str,
    /// Its pattern lies in uv, not in the world.
    in_uv: bool,
    /// Features in a pixel near by: so few that nothing of the pattern is below a pixel.
    near: f32,
}

fn cases() -> [Case; 8] {
    let case = |texture, swizzle, in_uv, near| Case {
        texture,
        swizzle,
        in_uv,
        near,
    };
    [
        case("checker", "", true, 0.02),
        case("fbm", "", false, 0.015),
        case("voronoi", ".x", false, 0.1),
        case("voronoi", ".y", false, 0.1),
        case("voronoi", ".z", false, 0.1),
        case("scratches", "", true, 0.003),
        case("rust_mask", "", false, 0.005),
        case("rust_color", "", false, 0.003),
    ]
}

fn perspective() -> Projection {
    Projection::Perspective {
        y_fov: 2.0 * (SEEN / HEIGHT).atan(),
    }
}

/// What each pixel of a plane shows with so many features of the pattern in a pixel, and without fading if asked.
fn pixels(
    device: &Device,
    case: &Case,
    features: f32,
    fades: bool,
    projection: Projection,
    spp: u32,
) -> Vec<f64> {
    let file = format!("user_textures/{}.wgsl", case.texture);
    let path = root().join(file);
    let mut text = std::fs::read_to_string(path).expect("a standard texture");
    assert!(WIDTHS.iter().any(|(width, _)| text.contains(width)));
    if !fades {
        for (width, none) in WIDTHS {
            text = text.replace(width, none);
        }
    }
    let mut sources = TextureSources::default();
    sources.insert(case.texture, &text);

    let pixel = 2.0 * SEEN / SIDE as f32;
    let scale = features / pixel * if case.in_uv { PLANE } else { 1.0 };
    let look = format!(
        "[node.n]\ntexture='{}'\nscale={scale}\n[material.'material 0']\nbase_color='n{}'\n",
        case.texture, case.swizzle
    );
    // A little tilted, so that it doesn't lie in one layer of a lattice.
    let along = Vec3::new(1.0, 0.15, 0.0).normalize() * PLANE;
    let back = Vec3::NEG_Z * PLANE;
    let plane = quad((along + back) * -0.5, along, back);
    let surface = Material {
        unlit: true,
        ..Material::default()
    };
    let mut scene = scene([(plane, surface)], Vec3::ZERO);
    let procedural = textured(&mut scene, &look, &sources);
    let above = camera(Vec3::Y * HEIGHT, Vec3::ZERO, Vec3::NEG_Z, projection);
    let shot = Shot {
        size: (SIDE, SIDE),
        max_depth: 1,
        spp,
    };
    let film = render_textured(device, &scene, &procedural, &above, shot);
    film.mean().iter().map(|p| f64::from(p[0])).collect()
}

fn mean_and_deviation(pixels: &[f64]) -> (f64, f64) {
    let n = pixels.len() as f64;
    let mean = pixels.iter().sum::<f64>() / n;
    let variance = pixels.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

#[test]
fn from_afar_one_sample_shows_the_mean() {
    let Some(device) = device::open() else { return };
    for case in cases() {
        let name = format!("{}{}", case.texture, case.swizzle);
        // The pattern as it is: its mean, known to 1 / 512 of its deviation, and how far single samples are from it.
        let (mean, _) = mean_and_deviation(&pixels(&device, &case, FAR, false, perspective(), 64));
        let aliased = pixels(&device, &case, FAR, false, perspective(), 1);
        let (_, deviation) = mean_and_deviation(&aliased);
        let is_near = |pixel: &&f64| (**pixel - mean).abs() <= BAND * deviation;
        let share = aliased.iter().filter(is_near).count() as f64 / aliased.len() as f64;
        assert!(share < 0.4, "{name}: the test finds noise, {share}");

        let orthographic = Projection::Orthographic { y_mag: SEEN };
        for projection in [perspective(), orthographic] {
            let faded = pixels(&device, &case, FAR, true, projection, 1);
            let off = faded.iter().map(|p| (p - mean).abs() / deviation);
            let worst = off.fold(0.0, f64::max);
            let (faded, _) = mean_and_deviation(&faded);
            assert!(
                worst <= BAND,
                "{name}, {projection:?}: a pixel is {worst} deviations off; {faded} instead of {mean} ± {deviation}"
            );
        }
    }
}

#[test]
fn from_near_the_pattern_has_its_full_contrast() {
    let Some(device) = device::open() else { return };
    for case in cases() {
        let name = format!("{}{}", case.texture, case.swizzle);
        let [faded, pattern] = [true, false].map(|fades| {
            mean_and_deviation(&pixels(&device, &case, case.near, fades, perspective(), 4)).1
        });
        assert!(pattern > 0.01, "{name}: a pattern is seen, {pattern}");
        // Edges of a checkerboard are as soft as a pixel is wide.
        assert!(faded > 0.98 * pattern, "{name}: {faded} of {pattern}");
    }
}
