//! Light from infinitely far away: environment pictures, and `extras.environment` of a glTF scene.
//!
//! glTF has no environment of its own. A scene may carry one in its extras:
//! `{"constant": [r, g, b]}`, or `{"uri": "sky.exr"}` (also `"file"`) with an optional rotation about +Y in degrees
//! (`"rotation"` or `"rotation_y_deg"`) or as a row-major matrix (`"mitsuba_toWorld_row_major"`), and in both cases
//! a factor (`"scale"` or `"intensity"`).

use super::document::Document;
use super::error::{At as _, Fault, ImportError, Warnings};
use super::files::{self, Source};
use crate::scene::{Environment, FloatImage};
use exr::prelude as exr;
use glam::Vec3;
use image::{DynamicImage, ImageDecoder as _, ImageReader, Limits};
use serde_json::Value;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Longest side, texels.
const MAX_SIDE: usize = 32768;
/// Texels of an environment; 16384 x 8192, 1.5 GiB in memory.
const MAX_TEXELS: u64 = 1 << 27;
/// Largest file (4 GiB).
const MAX_FILE: u64 = 4 << 30;

/// Reads an equirectangular picture: OpenEXR or Radiance HDR, or PNG, JPEG and WebP, which are taken as sRGB.
/// Returns it with warnings: values that are negative or not finite become 0.
///
/// # Errors
/// Where the file can't be read, is damaged, or is larger than 2^27 texels.
pub fn load_environment_image(path: &Path) -> Result<(FloatImage, Vec<String>), ImportError> {
    let bytes = files::read_file(path, MAX_FILE).map_err(|source| ImportError::Read {
        path: path.to_owned(),
        source,
    })?;
    // The decoders are foreign code fed with foreign bytes: a panic in one must not end the program.
    let decoded = catch_unwind(AssertUnwindSafe(|| decode(&bytes)))
        .unwrap_or_else(|_| Err("the decoder gave up on it".into()));
    let mut image = decoded.map_err(|problem| ImportError::Environment {
        path: path.to_owned(),
        problem,
    })?;
    let mut bad = 0u64;
    for value in image.rgb.iter_mut().flatten() {
        if !(value.is_finite() && *value >= 0.0) {
            *value = 0.0;
            bad += 1;
        }
    }
    let warnings = match bad {
        0 => Vec::new(),
        _ => vec![format!(
            "{}: {bad} values are negative or not finite; 0 is used",
            path.display()
        )],
    };
    Ok((image, warnings))
}

/// The environment in the extras of a scene; black where there is none.
pub(super) fn of_scene(
    document: &Document,
    scene: Option<usize>,
    warnings: &mut Warnings,
) -> Result<Environment, ImportError> {
    let extras = scene.and_then(|scene| document.environments.get(scene)?.as_ref());
    let Some(extras) = extras else {
        return Ok(Environment::default());
    };
    let place = || "scene extras, environment".to_owned();
    let scale = match number(extras, &["scale", "intensity"]) {
        None => 1.0,
        Some(scale) if scale >= 0.0 && scale.is_finite() => scale,
        Some(scale) => {
            return Err(format!("the factor {scale} is not a positive number"))
                .at(&document.path, place);
        }
    };
    if let Some(color) = extras.get("constant") {
        let color = serde_json::from_value::<[f32; 3]>(color.clone())
            .map(|color| Vec3::from(color) * scale)
            .ok()
            .filter(|color| color.is_finite() && color.min_element() >= 0.0)
            .ok_or_else(|| "\"constant\" must be three numbers that are not negative".to_owned())
            .at(&document.path, place)?;
        return Ok(Environment::Constant(color));
    }
    let uri = ["uri", "file"]
        .iter()
        .find_map(|key| extras.get(*key)?.as_str());
    let Some(uri) = uri else {
        return Err("has neither \"constant\" nor \"uri\"".to_owned()).at(&document.path, place);
    };
    let Source::File(path) = files::resolve(document.folder(), uri).at(&document.path, place)?
    else {
        return Err("must be a file".to_owned()).at(&document.path, place);
    };
    let (image, image_warnings) = load_environment_image(&path)?;
    image_warnings
        .into_iter()
        .for_each(|warning| warnings.push(warning));
    Ok(Environment::Image {
        image,
        rotation: rotation(extras, warnings).at(&document.path, place)?,
        intensity: scale,
    })
}

fn number(extras: &Value, keys: &[&str]) -> Option<f32> {
    keys.iter()
        .find_map(|key| extras.get(*key)?.as_f64())
        .map(|value| value as f32)
}

/// Degrees about +Y.
fn rotation(extras: &Value, warnings: &mut Warnings) -> Result<f32, Fault> {
    if let Some(degrees) = number(extras, &["rotation", "rotation_y_deg"]) {
        return if degrees.is_finite() {
            Ok(degrees)
        } else {
            Err("the rotation is not finite".into())
        };
    }
    let Some(matrix) = extras.get("mitsuba_toWorld_row_major") else {
        return Ok(0.0);
    };
    let matrix = serde_json::from_value::<[f32; 16]>(matrix.clone())
        .map_err(|_| "the matrix must have 16 numbers")?;
    // A turn by a about +Y has cos a, 0, sin a in its first row. A map that is turned by it is read at u + a / 360.
    let (cos, sin) = (matrix[0], matrix[2]);
    let turn = [cos, 0.0, sin, 0.0, 1.0, 0.0, -sin, 0.0, cos];
    let actual = [0, 1, 2, 4, 5, 6, 8, 9, 10].map(|i| matrix[i]);
    if turn.iter().zip(actual).any(|(a, b)| (a - b).abs() > 1e-3) {
        warnings.push(
            "environment: only turns about +Y are supported; the rest of its matrix is ignored",
        );
    }
    let degrees = sin.atan2(cos).to_degrees();
    Ok(if degrees.is_finite() { degrees } else { 0.0 })
}

fn decode(bytes: &[u8]) -> Result<FloatImage, Fault> {
    if bytes.starts_with(&[0x76, 0x2F, 0x31, 0x01]) {
        return decode_exr(bytes);
    }
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| error.to_string())?;
    if reader.format().is_none() {
        return Err("is not a picture that can be read".into());
    }
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(MAX_SIDE as u32);
    limits.max_image_height = Some(MAX_SIDE as u32);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions();
    check_size(width as usize, height as usize)?;
    let picture = DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())?;
    let is_float = matches!(
        picture,
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
    );
    let mut rgb: Vec<[f32; 3]> = picture
        .into_rgb32f()
        .pixels()
        .map(|pixel| pixel.0)
        .collect();
    if !is_float {
        rgb.iter_mut()
            .flatten()
            .for_each(|value| *value = srgb_to_linear(*value));
    }
    Ok(FloatImage { width, height, rgb })
}

fn decode_exr(bytes: &[u8]) -> Result<FloatImage, Fault> {
    use exr::{ReadChannels as _, ReadLayers as _, ReadSpecificChannel as _};
    let message = |error: exr::Error| error.to_string();
    let meta = exr::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(message)?;
    // Before any texel is allocated: all sizes the headers claim, against limits and against the bytes of the file.
    for header in &meta.headers {
        check_size(header.layer_size.0, header.layer_size.1)?;
        if header.chunk_count > bytes.len() / 8 {
            return Err("claims more blocks than the file has bytes for".into());
        }
    }
    let header = meta.headers.first().ok_or("has no layer")?;
    let has = |name: &str| {
        header
            .channels
            .find_index_of_channel(&name.into())
            .is_some()
    };
    if !has("R") && has("Y") {
        let image = exr::read()
            .no_deep_data()
            .largest_resolution_level()
            .specific_channels()
            .required("Y")
            .collect_pixels(
                |size, _| blank(size),
                |image: &mut FloatImage, at, (y,): (f32,)| set(image, at, [y; 3]),
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .map_err(message)?;
        return Ok(image.layer_data.channel_data.pixels);
    }
    let image = exr::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| blank(size),
            |image: &mut FloatImage, at, (r, g, b): (f32, f32, f32)| {
                set(image, at, [r, g, b]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(message)?;
    Ok(image.layer_data.channel_data.pixels)
}

fn blank(size: exr::Vec2<usize>) -> FloatImage {
    FloatImage {
        width: size.0 as u32,
        height: size.1 as u32,
        rgb: vec![[0.0; 3]; size.0 * size.1],
    }
}

fn set(image: &mut FloatImage, at: exr::Vec2<usize>, rgb: [f32; 3]) {
    let width = image.width as usize;
    image.rgb[at.1 * width + at.0] = rgb;
}

fn check_size(width: usize, height: usize) -> Result<(), Fault> {
    let texels = (width as u64).saturating_mul(height as u64);
    if width == 0 || height == 0 {
        return Err("has no texels".into());
    }
    if width > MAX_SIDE || height > MAX_SIDE || texels > MAX_TEXELS {
        return Err(format!(
            "claims {width} x {height} texels, at most 16384 x 8192 are read"
        ));
    }
    Ok(())
}

fn srgb_to_linear(value: f32) -> f32 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn degrees(extras: Value) -> f32 {
        rotation(&extras, &mut Warnings::default()).unwrap()
    }

    #[test]
    fn a_matrix_and_degrees_about_y_agree() {
        let (sin, cos) = 110f32.to_radians().sin_cos();
        let matrix = json!([cos, 0, sin, 0, 0, 1, 0, 0, -sin, 0, cos, 0, 0, 0, 0, 1]);
        let turned = degrees(json!({ "mitsuba_toWorld_row_major": matrix }));
        assert!((turned - 110.0).abs() < 1e-3, "{turned}");
        assert_eq!(degrees(json!({ "rotation_y_deg": 110.0 })), 110.0);
    }

    #[test]
    fn other_matrices_warn() {
        let mut warnings = Warnings::default();
        let tipped = json!({ "mitsuba_toWorld_row_major": [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1] });
        rotation(&tipped, &mut warnings).unwrap();
        assert_eq!(warnings.into_vec().len(), 1);
    }

    #[test]
    fn sizes_are_checked_before_texels_exist() {
        check_size(0, 4).unwrap_err();
        check_size(usize::MAX, usize::MAX).unwrap_err();
        check_size(16384, 8192).unwrap();
    }
}
