//! Light from infinitely far away: `extras.environment` of a glTF scene.
//!
//! glTF has no environment of its own. A scene may carry one in its extras:
//! `{"constant": [r, g, b]}`, or `{"uri": "sky.exr"}` (also `"file"`) with an optional rotation about +Y in degrees
//! (`"rotation"` or `"rotation_y_deg"`) or as a row-major matrix (`"mitsuba_toWorld_row_major"`), and in both cases
//! a factor (`"scale"` or `"intensity"`). Whatever else is called so is somebody else's, and is ignored.

use super::document::Document;
use super::files::{self, UriTarget};
use super::nodes::Kept;
use crate::Environment;
use crate::import::environment::load_environment_image;
use crate::import::error::{At as _, Fault, ImportError, Warnings};
use glam::Vec3;
use serde_json::Value;
use std::sync::{Arc, PoisonError};

/// What names a picture.
pub(super) const NAMES: &[&str] = &["uri", "file"];

/// The environment in the extras of a scene; black where there is none. What is kept of it is taken from there.
pub(super) fn of_scene(
    document: &Document,
    scene: Option<usize>,
    kept: Option<&Kept>,
    warnings: &mut Warnings,
) -> Result<Environment, ImportError> {
    let extras = scene.and_then(|scene| document.environments.get(scene)?.as_ref());
    let Some(extras) = extras else {
        return Ok(Environment::default());
    };
    let Some(kept) = kept else {
        return read(document, extras, warnings);
    };
    let mut kept = (kept.environment.lock()).unwrap_or_else(PoisonError::into_inner);
    let (environment, told) = match kept.take() {
        Some(known) => known,
        None => {
            let mut own = Warnings::default();
            let environment = read(document, extras, &mut own)?;
            (environment, own.into_vec())
        }
    };
    told.iter().for_each(|warning| warnings.push(warning));
    *kept = Some((environment.clone(), told));
    Ok(environment)
}

fn read(
    document: &Document,
    extras: &Value,
    warnings: &mut Warnings,
) -> Result<Environment, ImportError> {
    if !["constant"]
        .iter()
        .chain(NAMES)
        .any(|key| extras.get(*key).is_some())
    {
        warnings.push("the scene's extras have an `environment` with neither \"constant\" nor \"uri\"; it is ignored");
        return Ok(Environment::default());
    }
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
    let uri = NAMES.iter().find_map(|key| extras.get(*key)?.as_str());
    let Some(uri) = uri else {
        return Err("its \"uri\" is not the name of a file".to_owned()).at(&document.path, place);
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
        image: Arc::new(image),
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
    use super::super::tests::{import, square};
    use super::*;
    use serde_json::json;

    #[test]
    fn what_others_call_an_environment_is_ignored() {
        for foreign in [json!("studio"), json!(3), json!([1, 2]), json!({ "id": 7 })] {
            let mut tree = square();
            let extras = json!({ "environment": foreign });
            tree["scenes"] = json!([{ "nodes": [0], "extras": extras }]);
            let imported = import(tree).expect("it is shown");
            assert!(imported.environment_problem.is_none(), "{foreign}");
            let said = imported.warnings.join("\n");
            assert!(said.contains("`environment`"), "{foreign}: {said}");
        }
    }

    #[test]
    fn one_that_cannot_be_read_is_a_problem_of_its_own() {
        for (own, says) in [
            (json!({ "uri": "no such.exr" }), "no such.exr"),
            (json!({ "uri": 3 }), "not the name of a file"),
            (json!({ "constant": [1, -2, 3] }), "not negative"),
        ] {
            let mut tree = square();
            let extras = json!({ "environment": own });
            tree["scenes"] = json!([{ "nodes": [0], "extras": extras }]);
            let imported = import(tree).expect("all else is there");
            let problem = imported.environment_problem.expect("it is told");
            assert!(problem.to_string().contains(says), "{problem}");
        }
    }

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
