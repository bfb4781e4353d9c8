//! Every model of a folder in one picture, each in the same light and from the same side, with its name.
//!
//! `cargo run --release --example contact_sheet -- FOLDER SHEET.jpg [ENVIRONMENT.hdr] [SPP] [HIDDEN ...]`
//!
//! Models that are hidden are rendered and judged, but not shown: their licences may not allow it. Prints a line for each model, and fails where one can't be rendered or has samples that are not finite.

mod label;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use device::Device;
use engine::load::load;
use engine::renderer::{RenderSettings, Renderer};
use engine::scene::import::load_environment_image;
use engine::scene::{Camera, Environment, Projection, Scene};
use glam::{Affine3A, Mat3A, Vec3};
use image::codecs::jpeg::JpegEncoder;
use image::{Rgb, RgbImage};

/// Side of a model's picture, and the strip below it for the name, pixels.
const TILE: u32 = 168;
const STRIP: u32 = 12;
const COLUMNS: u32 = 8;
/// Largest file.
const MOST_BYTES: usize = 300_000;
/// Where the camera stands, seen from the model: nearly in front, because test panels have their text there.
const FROM: Vec3 = Vec3::new(0.22, 0.27, 1.0);
/// Half of the picture's angle, and what part of it the model fills.
const HALF_FOV: f32 = 0.3;
const FILLED: f32 = 0.92;
/// Of the environment picture: white is white, not more.
const INTENSITY: f32 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [folder, sheet, rest @ ..] = args.as_slice() else {
        return Err(
            "usage: contact_sheet FOLDER SHEET.jpg [ENVIRONMENT.hdr] [SPP] [HIDDEN ...]".into(),
        );
    };
    let environment = match rest.first() {
        Some(path) => Environment::Image {
            image: load_environment_image(&engine::input::Disk, Path::new(path))?
                .0
                .into(),
            rotation: 0.0,
            intensity: INTENSITY,
        },
        None => Environment::Constant(Vec3::splat(INTENSITY)),
    };
    let spp = rest.get(1).map_or(Ok(64), |spp| spp.parse())?;
    let device = Device::best()?;
    let models = models(Path::new(folder))?;
    let rows = (models.len() as u32).div_ceil(COLUMNS);
    let mut picture = RgbImage::new(COLUMNS * TILE, rows * (TILE + STRIP));
    let mut failed = 0;
    let mut invalid = 0;
    for (place, (name, file)) in models.iter().enumerate() {
        let place = place as u32;
        let corner = (place % COLUMNS * TILE, place / COLUMNS * (TILE + STRIP));
        let label: String = name
            .chars()
            .take((TILE / label::PITCH) as usize - 1)
            .collect();
        label::write(&mut picture, corner.0 + 2, corner.1 + TILE + 2, &label);
        let clock = Instant::now();
        match render(&device, file, &environment, spp) {
            Ok(shot) => {
                invalid += shot.invalid;
                println!(
                    "{name}: {} triangles, {} samples not finite, {:.1} s",
                    shot.triangles,
                    shot.invalid,
                    clock.elapsed().as_secs_f64()
                );
                if rest.iter().skip(2).any(|hidden| hidden == name) {
                    continue;
                }
                for (at, pixel) in (0..).zip(shot.pixels) {
                    picture.put_pixel(corner.0 + at % TILE, corner.1 + at / TILE, pixel);
                }
            }
            Err(error) => {
                failed += 1;
                println!("{name}: {error}");
            }
        }
    }
    std::fs::write(sheet, small_jpeg(&picture)?)?;
    println!(
        "{} models, {failed} failed, {} samples, {invalid} not finite",
        models.len(),
        (models.len() - failed) as u64 * u64::from(TILE * TILE) * u64::from(spp)
    );
    match failed as u64 + invalid {
        0 => Ok(()),
        _ => Err("not every model is as it should be".into()),
    }
}

/// The first glTF file of each folder in a folder, by the folder's name.
fn models(folder: &Path) -> Result<Vec<(String, PathBuf)>, Box<dyn Error>> {
    let mut models = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if !entry.path().is_dir() {
            continue;
        }
        let mut files: Vec<PathBuf> = std::fs::read_dir(entry.path())?
            .map(|file| Ok(file?.path()))
            .collect::<Result<_, std::io::Error>>()?;
        files.sort();
        let is_model = |file: &PathBuf| file.extension().is_some_and(|e| e == "glb" || e == "gltf");
        if let Some(file) = files.into_iter().find(is_model) {
            models.push((entry.file_name().to_string_lossy().into_owned(), file));
        }
    }
    models.sort();
    Ok(models)
}

struct Shot {
    pixels: Vec<Rgb<u8>>,
    triangles: u64,
    invalid: u64,
}

fn render(
    device: &Device,
    file: &Path,
    environment: &Environment,
    spp: u32,
) -> Result<Shot, Box<dyn Error>> {
    let mut loaded = load(file, None, &[])?;
    loaded.scene.environment = environment.clone();
    let settings = RenderSettings::new(TILE, TILE, &view(&loaded.scene));
    let mut renderer = Renderer::new(device, &loaded.scene, &loaded.procedural, &settings)?;
    renderer.render(spp)?;
    let mean = renderer.film()?.mean();
    Ok(Shot {
        pixels: mean.iter().map(|p| Rgb(p.map(encode))).collect(),
        triangles: loaded.scene.instanced_triangles(),
        invalid: renderer.stats()?.invalid_samples,
    })
}

/// A camera that has all vertices just inside its picture.
fn view(scene: &Scene) -> Camera {
    let back = FROM.normalize();
    let right = Vec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let points = || {
        scene.instances.iter().flat_map(|instance| {
            let positions = &scene.meshes[instance.mesh as usize].positions;
            positions
                .iter()
                .map(|&p| instance.transform.transform_point3(p))
        })
    };
    let low = points().fold(Vec3::INFINITY, Vec3::min);
    let high = points().fold(Vec3::NEG_INFINITY, Vec3::max);
    let center = 0.5 * (low + high);
    let slope = FILLED * HALF_FOV.tan();
    let distance = points().fold(0.0, |distance: f32, p| {
        let p = p - center;
        let aside = p.dot(right).abs().max(p.dot(up).abs());
        distance.max(p.dot(back) + aside / slope)
    });
    Camera {
        name: "front".to_owned(),
        transform: Affine3A {
            matrix3: Mat3A::from_cols(right.into(), up.into(), back.into()),
            translation: (center + back * distance).into(),
        },
        projection: Projection::Perspective {
            y_fov: 2.0 * HALF_FOV,
        },
        aperture_radius: 0.0,
        aperture_blades: 0,
        aperture_rotation: 0.0,
        focus_distance: 1.0,
    }
}

/// Linear to 8-bit sRGB (IEC 61966-2-1).
fn encode(linear: f32) -> u8 {
    let v = if linear <= 0.0031308 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (v.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// The best JPEG that is not too large.
fn small_jpeg(picture: &RgbImage) -> Result<Vec<u8>, Box<dyn Error>> {
    for quality in (30..=90).rev().step_by(3) {
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, quality).encode_image(picture)?;
        if bytes.len() <= MOST_BYTES {
            return Ok(bytes);
        }
    }
    Err("the picture is too large at any quality".into())
}
