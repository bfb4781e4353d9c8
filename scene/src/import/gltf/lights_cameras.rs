//! Cameras and punctual lights of a file, placed in the world.

use crate::import::error::Warnings;
use crate::{Camera, LightKind, Projection, PunctualLight};
use glam::{Affine3A, DAffine3, DQuat, Mat3A, Vec3};
use gltf::json;
use json::extensions::scene::khr_lights_punctual::{Light, Type};
use json::validation::Checked;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Focus distance where nothing says better, metres.
const FOCUS_DISTANCE: f32 = 1.0;

/// Places a camera whose node and those above it `turn` it so. `None`, with a warning, where its numbers describe no view.
pub(super) fn camera(
    source: &json::Camera,
    name: String,
    world: &DAffine3,
    turn: DQuat,
    warnings: &mut Warnings,
) -> Option<Camera> {
    let Some(transform) = placed(world, turn) else {
        warnings.push(format!(
            "camera \"{name}\": its transform is not finite; it is left out"
        ));
        return None;
    };
    let projection = match (source.type_, &source.perspective, &source.orthographic) {
        (Checked::Valid(json::camera::Type::Perspective), Some(view), _) => {
            Projection::Perspective { y_fov: view.yfov }
        }
        (Checked::Valid(json::camera::Type::Orthographic), _, Some(view)) => {
            Projection::Orthographic {
                // Where the sign is wrong the size is still meant.
                y_mag: view.ymag.abs(),
            }
        }
        _ => {
            warnings.push(format!(
                "camera \"{name}\": has no projection; it is left out"
            ));
            return None;
        }
    };
    let valid = match projection {
        Projection::Perspective { y_fov } => y_fov > 0.0 && y_fov < PI,
        Projection::Orthographic { y_mag } => y_mag > 0.0 && y_mag.is_finite(),
    };
    if !valid {
        warnings.push(format!(
            "camera \"{name}\": its angle or size is out of range; it is left out"
        ));
        return None;
    }
    Some(Camera {
        name,
        transform,
        projection,
        aperture_radius: 0.0,
        aperture_blades: 0,
        aperture_rotation: 0.0,
        focus_distance: FOCUS_DISTANCE,
    })
}

/// Places a light of KHR_lights_punctual. `None`, with a warning, where it can't shine.
pub(super) fn light(
    source: &Light,
    name: String,
    world: &DAffine3,
    warnings: &mut Warnings,
) -> Option<PunctualLight> {
    let color = Vec3::from(source.color);
    let intensity = color * source.intensity;
    let position = world.translation.as_vec3();
    let direction = world
        .transform_vector3(-glam::DVec3::Z)
        .as_vec3()
        .normalize_or_zero();
    let kind = match source.type_ {
        Checked::Valid(Type::Point) => LightKind::Point,
        Checked::Valid(Type::Directional) => LightKind::Directional,
        Checked::Valid(Type::Spot) => spot(source, &name, warnings),
        Checked::Invalid => {
            warnings.push(format!(
                "light \"{name}\": has an unknown type; it is left out"
            ));
            return None;
        }
    };
    let needs_direction = kind != LightKind::Point;
    let usable =
        is_sound(source) && position.is_finite() && (direction != Vec3::ZERO || !needs_direction);
    if !usable {
        warnings.push(format!(
            "light \"{name}\": its intensity or transform can't be used; it is left out"
        ));
        return None;
    }
    let range = match source.range {
        Some(range) if range > 0.0 => range,
        Some(_) => {
            warnings.push(format!(
                "light \"{name}\": its range is not positive and is ignored"
            ));
            f32::INFINITY
        }
        None => f32::INFINITY,
    };
    Some(PunctualLight {
        name,
        intensity,
        position,
        direction: if direction == Vec3::ZERO {
            Vec3::NEG_Z
        } else {
            direction
        },
        range,
        kind,
    })
}

/// Whether a light can be used, wherever its node stands: one that can't isn't there at any moment.
pub(super) fn is_sound(source: &Light) -> bool {
    let intensity = Vec3::from(source.color) * source.intensity;
    let has_type = matches!(source.type_, Checked::Valid(_));
    has_type && intensity.is_finite() && intensity.min_element() >= 0.0
}

fn spot(source: &Light, name: &str, warnings: &mut Warnings) -> LightKind {
    let (inner, outer) = source.spot.as_ref().map_or((0.0, FRAC_PI_4), |spot| {
        (spot.inner_cone_angle, spot.outer_cone_angle)
    });
    let clamped_outer = if outer.is_finite() {
        outer.clamp(1e-3, FRAC_PI_2)
    } else {
        FRAC_PI_4
    };
    let clamped_inner = if inner.is_finite() {
        inner.clamp(0.0, clamped_outer)
    } else {
        0.0
    };
    if (clamped_inner, clamped_outer) != (inner, outer) {
        warnings.push(format!(
            "light \"{name}\": cone angles {inner} and {outer} are out of range; {clamped_inner} and {clamped_outer} are used"
        ));
    }
    LightKind::Spot {
        inner_angle: clamped_inner,
        outer_angle: clamped_outer,
    }
}

/// Where a camera is. Scales mean nothing to it (glTF 2.0, section 3.10.2): scaled to nothing, it still looks where its turns say.
fn placed(world: &DAffine3, turn: DQuat) -> Option<Affine3A> {
    let flat = || DAffine3::from_rotation_translation(turn, world.translation);
    match world.is_finite() {
        true => rigid(world).or_else(|| rigid(&flat())),
        false => None,
    }
}

/// The transform without scale and shear: looks along the same -Z with +Y as near up as a rotation allows.
fn rigid(world: &DAffine3) -> Option<Affine3A> {
    let back = world.matrix3.z_axis.normalize_or_zero();
    let right = world.matrix3.y_axis.cross(back).normalize_or_zero();
    if right == glam::DVec3::ZERO || !world.is_finite() {
        return None;
    }
    let up = back.cross(right);
    let rigid = Affine3A {
        matrix3: Mat3A::from_cols(
            right.as_vec3().into(),
            up.as_vec3().into(),
            back.as_vec3().into(),
        ),
        translation: world.translation.as_vec3().into(),
    };
    rigid.is_finite().then_some(rigid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn scale_and_mirroring_do_not_reach_the_camera() {
        let world = DAffine3::from_scale_rotation_translation(
            DVec3::new(-3.0, 0.5, 7.0),
            DQuat::from_rotation_y(0.4),
            DVec3::new(1.0, 2.0, 3.0),
        );
        let camera = rigid(&world).unwrap();
        assert!((camera.matrix3.determinant() - 1.0).abs() < 1e-5);
        let looks = camera.transform_vector3(Vec3::NEG_Z);
        let expected = DQuat::from_rotation_y(0.4).mul_vec3(DVec3::NEG_Z).as_vec3();
        assert!(looks.abs_diff_eq(expected, 1e-5));
        assert!(rigid(&DAffine3::from_scale(DVec3::ZERO)).is_none());
    }

    #[test]
    fn a_camera_that_is_scaled_to_nothing_looks_where_it_is_turned() {
        let turn = DQuat::from_rotation_y(0.4);
        let to = DVec3::new(1.0, 2.0, 3.0);
        for scale in [DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)] {
            let world = DAffine3::from_scale_rotation_translation(scale, turn, to);
            let camera = placed(&world, turn).expect("it has a place");
            let looks = camera.transform_vector3(Vec3::NEG_Z);
            let expected = turn.mul_vec3(DVec3::NEG_Z).as_vec3();
            assert!(looks.abs_diff_eq(expected, 1e-5), "{looks}");
            assert_eq!(Vec3::from(camera.translation), to.as_vec3());
        }
        assert!(placed(&DAffine3::from_scale(DVec3::INFINITY), turn).is_none());
    }
}
