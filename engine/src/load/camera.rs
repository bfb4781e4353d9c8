//! The look's camera: overrides of a camera of the scene.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use texgen::Diagnostic;

use crate::scene::look::Look;
use crate::scene::{Camera, Projection, Scene};

use super::{camera_remedy, first_camera};

/// Height of a 35 mm film's picture, metres.
const SENSOR_HEIGHT: f32 = 0.024;

/// The camera that a look asks for. Where the scene has none, `still` is what it starts from, or a view of everything.
pub(super) fn resolve(
    look: &Look,
    scene: &Scene,
    still: Option<&Camera>,
) -> Result<Camera, Diagnostic> {
    let wanted = &look.camera;
    let mut camera = match &wanted.name {
        None => first_camera(scene, still),
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
    if let Some(number) = &wanted.f_number {
        let Projection::Perspective { y_fov } = camera.projection else {
            let problem =
                Diagnostic::error("an orthographic camera has no focal length, so no `f_number`")
                    .with_label(&look.file, number.span.clone(), "")
                    .with_note(
                        "set `aperture_radius` instead, or `y_fov` for a perspective camera",
                    );
            return Err(problem);
        };
        let height = wanted
            .sensor_height
            .as_ref()
            .map_or(SENSOR_HEIGHT, |h| h.value);
        let focal_length = 0.5 * height / (0.5 * y_fov).tan();
        camera.aperture_radius = 0.5 * focal_length / number.value;
    }
    if let Some(blades) = wanted.blades {
        camera.aperture_blades = blades;
    }
    if let Some(rotation) = &wanted.blade_rotation {
        camera.aperture_rotation = rotation.value.to_radians();
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
