//! The look's camera: overrides of a camera of the scene.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use texgen::Diagnostic;

use crate::scene::look::Look;
use crate::scene::{Camera, Projection, Scene};

use super::{camera_remedy, first_camera};

/// The camera that a look asks for.
pub(super) fn resolve(look: &Look, scene: &Scene) -> Result<Camera, Diagnostic> {
    let wanted = &look.camera;
    let mut camera = match &wanted.name {
        None => first_camera(scene),
        Some(name) => {
            let found = scene.cameras.iter().find(|c| c.name == name.value);
            found.cloned().ok_or_else(|| {
                Diagnostic::error(format!("the scene has no camera called `{}`", name.value))
                    .with_label(&look.file, name.span.clone(), "")
                    .with_note(camera_remedy(scene, &name.value))
            })?
        }
    };
    if let Some(position) = &wanted.position {
        camera.transform.translation = position.value.into();
    }
    let eye = Vec3::from(camera.transform.translation);
    let axes = camera.transform.matrix3;
    let mut forward = Vec3::from(-axes.z_axis);
    if let Some(target) = &wanted.look_at {
        let way = target.value - eye;
        if way.length() < 1e-6 {
            let problem = Diagnostic::error(
                "the camera stands where it looks at: `look_at` has no direction",
            )
            .with_label(&look.file, target.span.clone(), "")
            .with_note("set `position` as well, or another `look_at`");
            return Err(problem);
        }
        forward = way.normalize();
        camera.focus_distance = way.length();
    }
    if wanted.look_at.is_some() || wanted.up.is_some() {
        let up = wanted.up.as_ref().map_or(Vec3::Y, |up| up.value);
        camera.transform = looking(eye, forward, up.normalize());
    }
    if let Some(y_fov) = &wanted.y_fov {
        camera.projection = Projection::Perspective {
            y_fov: y_fov.value.to_radians(),
        };
    }
    if let Some(radius) = &wanted.aperture_radius {
        camera.aperture_radius = radius.value;
    }
    if let Some(distance) = &wanted.focus_distance {
        camera.focus_distance = distance.value;
    }
    Ok(camera)
}

/// A camera at `eye` that looks along `forward`, with `up` up in the picture as far as that is possible.
fn looking(eye: Vec3, forward: Vec3, up: Vec3) -> Affine3A {
    let side = forward.cross(up);
    let right = match side.length_squared() > 1e-8 {
        true => side.normalize(),
        // Straight up or down: any roll is as good.
        false => forward.any_orthonormal_vector(),
    };
    Affine3A {
        matrix3: Mat3A::from_cols(right.into(), right.cross(forward).into(), (-forward).into()),
        translation: Vec3A::from(eye),
    }
}
