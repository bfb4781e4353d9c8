//! Light from infinitely far away: `extras.environment` of a glTF scene.
//!
//! glTF has no environment of its own. A scene may carry one in its extras:
//! `{"constant": [r, g, b]}`, or `{"uri": "sky.exr"}` (also `"file"`) with an optional rotation about +Y in degrees
//! (`"rotation"` or `"rotation_y_deg"`) or as a row-major matrix (`"mitsuba_toWorld_row_major"`), and in both cases
//! a factor (`"scale"` or `"intensity"`).

use super::document::Document;
use super::files::{self, UriTarget};
use crate::Environment;
use crate::import::environment::load_environment_image;
use crate::import::error::{At as _, Fault, ImportError, Warnings};
use glam::Vec3;
use serde_json::Value;

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
    let UriTarget::File(path) =
        files::resolve(&*document.files, document.folder(), uri).at(&document.path, place)?
    else {
        return Err("must be a file".to_owned()).at(&document.path, place);
    };
    let (image, image_warnings) = load_environment_image(&*document.files, &path)?;
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
}
