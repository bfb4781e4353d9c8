//! Cameras, and a view for scenes that have none.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};

use crate::Scene;

/// A camera in the world. It looks along its local -Z, +Y is up.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Name of the camera or of its node.
    pub name: String,
    /// Camera to world, rigid (scale removed).
    pub transform: Affine3A,
    /// What it sees.
    pub projection: Projection,
    /// Radius of the lens, metres; 0 is a pinhole.
    pub aperture_radius: f32,
    /// Sides of the aperture: a regular polygon with its corners on the circle of that radius. Below 3 it is the disk.
    pub aperture_blades: u32,
    /// Turn of the polygon, radians, counter-clockwise as the camera sees the picture; at 0 a corner points to the right.
    pub aperture_rotation: f32,
    /// Distance of the plane in focus, metres.
    pub focus_distance: f32,
}

/// Projection of a camera. The picture's own aspect ratio is used; the vertical extent is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Vertical field of view, radians.
    Perspective {
        /// Radians.
        y_fov: f32,
    },
    /// Half of the height of the view, metres.
    Orthographic {
        /// Metres.
        y_mag: f32,
    },
}

impl Camera {
    /// For pictures that are so many times as wide as high: where they are narrower than high, it stands so far back that what it saw
    /// of the things around its focus from top to bottom is seen from side to side.
    #[must_use]
    pub fn fitted(&self, aspect: f32) -> Self {
        let mut fitted = self.clone();
        if !(1e-4..1.0).contains(&aspect) {
            return fitted;
        }
        match &mut fitted.projection {
            Projection::Orthographic { y_mag } => *y_mag /= aspect,
            Projection::Perspective { y_fov } => {
                let half = 0.5 * *y_fov;
                let across = (half.tan() * aspect).atan();
                let distance = self.focus_distance * half.sin() / across.sin();
                let back = self.transform.matrix3.z_axis;
                fitted.transform.translation += back * (distance - self.focus_distance);
                fitted.focus_distance = distance;
            }
        }
        fitted
    }
}

/// A view of the whole scene from the front, somewhat above and to the right, for pictures that aren't narrower than high; see
/// [`Camera::fitted`]. Of an empty scene: the origin.
pub fn default_camera(scene: &Scene) -> Camera {
    const Y_FOV: f32 = 0.7;
    let (low, high) = scene.bounds().unwrap_or((Vec3::NEG_ONE, Vec3::ONE));
    let center = low * 0.5 + high * 0.5;
    let radius = ((high - low).length() * 0.5).clamp(1e-4, 1e15);
    let toward_eye = Vec3::new(0.55, 0.4, 1.0).normalize();
    // The bounding sphere fits into the cone of the vertical angle, with a little space around it.
    let distance = radius * 1.05 / (Y_FOV * 0.5).sin();
    let eye = center + toward_eye * distance;
    let right = Vec3::Y.cross(toward_eye).normalize();
    let up = toward_eye.cross(right);
    Camera {
        name: "default".into(),
        transform: Affine3A {
            matrix3: Mat3A::from_cols(right.into(), up.into(), toward_eye.into()),
            translation: Vec3A::from(eye),
        },
        projection: Projection::Perspective { y_fov: Y_FOV },
        aperture_radius: 0.0,
        aperture_blades: 0,
        aperture_rotation: 0.0,
        focus_distance: distance,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_camera_sees_all_corners() {
        let mut scene = Scene::default();
        let mesh = crate::Mesh {
            positions: vec![Vec3::new(-5.0, 2.0, 1.0), Vec3::new(9.0, 3.0, 4.0)],
            ..Default::default()
        };
        scene.meshes.push(mesh);
        scene.instances.push(crate::Instance {
            name: String::new(),
            mesh: 0,
            transform: Affine3A::IDENTITY,
            asset: None,
        });
        let camera = default_camera(&scene);
        let Projection::Perspective { y_fov } = camera.projection else {
            panic!("must be perspective");
        };
        for aspect in [0.25, 0.8, 1.0, 3.0] {
            let to_camera = camera.fitted(aspect).transform.inverse();
            for corner in 0..8 {
                let pick = |bit: u32, a: f32, b: f32| if corner >> bit & 1 == 0 { a } else { b };
                let corner = Vec3::new(pick(0, -5.0, 9.0), pick(1, 2.0, 3.0), pick(2, 1.0, 4.0));
                let p = to_camera.transform_point3(corner);
                let half = (y_fov * 0.5).tan();
                assert!(p.z < 0.0 && (p.y / -p.z).abs() < half, "{aspect}: {p}");
                assert!((p.x / -p.z).abs() < half * aspect, "{aspect}: {p}");
            }
        }
        let same = camera.fitted(1.5);
        assert_eq!(same.transform, camera.transform);
        assert!(default_camera(&Scene::default()).transform.is_finite());
    }
}
