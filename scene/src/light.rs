//! Punctual lights.

use glam::Vec3;

/// A light of KHR_lights_punctual, in world space. Numbers are radiometric one to one: candela is W/sr, lux is W/m².
#[derive(Debug, Clone)]
pub struct PunctualLight {
    /// Name in the file.
    pub name: String,
    /// Linear colour times intensity.
    pub intensity: Vec3,
    /// World position, metres (not used by a directional light).
    pub position: Vec3,
    /// Unit direction in which the light shines (not used by a point light).
    pub direction: Vec3,
    /// Distance at which glTF's range window reaches zero; infinite where the file gives none.
    pub range: f32,
    /// Its shape.
    pub kind: LightKind,
}

/// Largest angular diameter of a light, radians.
pub const MAX_ANGULAR_DIAMETER: f32 = std::f32::consts::FRAC_PI_2;

/// Shape of a punctual light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightKind {
    /// Intensity W/sr in all directions.
    Point,
    /// Intensity W/sr inside a cone; angles in radians from the axis.
    Spot {
        /// Full intensity inside.
        inner_angle: f32,
        /// Zero outside.
        outer_angle: f32,
    },
    /// Irradiance W/m² on a perpendicular surface.
    Directional,
    /// The same from an evenly bright disk in the sky, such as the sun: shadows get soft edges, mirrors and the camera see
    /// it. The disk's size leaves the irradiance as it is.
    Disk {
        /// Radians, greater than 0 and at most [`MAX_ANGULAR_DIAMETER`].
        angular_diameter: f32,
    },
}
