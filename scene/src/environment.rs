//! Light from infinitely far away.

use std::sync::Arc;

use glam::Vec3;

use crate::FloatImage;

/// Light from infinitely far away, seen by the camera too.
#[derive(Debug, Clone)]
pub enum Environment {
    /// The same radiance from everywhere; black is none.
    Constant(Vec3),
    /// An equirectangular picture.
    Image {
        /// Linear radiance. Scenes of other moments share it.
        image: Arc<FloatImage>,
        /// Degrees about +Y, counter-clockwise seen from above: direction (x, y, z) reads
        /// u = frac(atan2(x, -z) / 2π + rotation / 360), v = acos(y) / π.
        rotation: f32,
        /// Factor on the radiance.
        intensity: f32,
    },
}

impl Default for Environment {
    fn default() -> Self {
        Self::Constant(Vec3::ZERO)
    }
}
