//! What a scene is seen by that has no light, under a look that says nothing of its environment.

use std::{f32::consts::PI, sync::Arc};

use glam::Vec3;

use crate::scene::{Environment, FloatImage};

use super::{Loaded, has_no_lamp};

/// In place of light.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum StandIn {
    /// The same light from everywhere: what a picture in a file is made with.
    #[default]
    White,
    /// Three soft lamps in a grey room, so that forms and gloss are seen.
    Studio,
    /// None: the picture is black.
    Dark,
}

/// Texels around the horizon.
const WIDTH: u32 = 128;
/// Radiance of the room, below and above.
const FLOOR: f32 = 0.1;
const CEILING: f32 = 0.55;

/// Towards a lamp, its radiance, and the angles within which it has all of it and beyond which nothing, degrees.
struct Lamp {
    to: Vec3,
    radiance: f32,
    inner: f32,
    outer: f32,
}

/// For a camera that looks along -Z, as that of a file without one does: from the left in front, from the right, from behind.
const LAMPS: [Lamp; 3] = [
    Lamp {
        to: Vec3::new(-0.6, 0.7, 0.6),
        radiance: 8.0,
        inner: 14.0,
        outer: 24.0,
    },
    Lamp {
        to: Vec3::new(0.9, 0.25, 0.5),
        radiance: 1.8,
        inner: 18.0,
        outer: 38.0,
    },
    Lamp {
        to: Vec3::new(0.3, 0.6, -0.9),
        radiance: 5.0,
        inner: 10.0,
        outer: 20.0,
    },
];

impl StandIn {
    fn environment(self) -> Environment {
        match self {
            Self::White => Environment::Constant(Vec3::ONE),
            Self::Studio => studio(),
            Self::Dark => Environment::Constant(Vec3::ZERO),
        }
    }
}

impl Loaded {
    /// Is seen by this where it has no light.
    pub(crate) fn lit_by(&mut self, stand_in: StandIn) {
        let says_so = (self.look.as_ref()).is_some_and(|look| look.environment.is_some());
        let is_lamp = |material| self.procedural.traits(material).is_lamp;
        let has_light = self.has_given_environment || self.has_gone_lights;
        if !says_so && !has_light && has_no_lamp(&self.scene, is_lamp) {
            self.scene.environment = stand_in.environment();
        }
    }
}

/// As bright as a white sky, taken over all directions.
fn studio() -> Environment {
    let height = WIDTH / 2;
    let mut rgb = Vec::with_capacity((WIDTH * height) as usize);
    let (mut sum, mut weights) = (0.0, 0.0);
    for y in 0..height {
        let polar = PI * (y as f32 + 0.5) / height as f32;
        for x in 0..WIDTH {
            let turn = 2.0 * PI * (x as f32 + 0.5) / WIDTH as f32;
            let direction = Vec3::new(
                polar.sin() * turn.sin(),
                polar.cos(),
                -polar.sin() * turn.cos(),
            );
            let radiance = radiance(direction);
            sum += radiance * polar.sin();
            weights += polar.sin();
            rgb.push(radiance);
        }
    }
    let scale = weights / sum;
    Environment::Image {
        image: Arc::new(FloatImage {
            width: WIDTH,
            height,
            rgb: rgb
                .into_iter()
                .map(|radiance| [radiance * scale; 3])
                .collect(),
        }),
        rotation: 0.0,
        intensity: 1.0,
    }
}

/// From a direction of unit length, before it is made as bright as a white sky.
fn radiance(direction: Vec3) -> f32 {
    let step = |from: f32, to: f32, x: f32| {
        let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    let room = FLOOR + (CEILING - FLOOR) * step(-0.6, 0.8, direction.y);
    let lamps = LAMPS.iter().map(|lamp| {
        let angle = direction.dot(lamp.to.normalize()).clamp(-1.0, 1.0).acos();
        lamp.radiance * (1.0 - step(lamp.inner, lamp.outer, angle.to_degrees()))
    });
    room + lamps.sum::<f32>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_studio_is_as_bright_as_a_white_sky_and_neutral() {
        let Environment::Image { image, .. } = studio() else {
            panic!("a picture");
        };
        let row = |y: u32| (PI * (y as f32 + 0.5) / image.height as f32).sin();
        let (mut sum, mut weights) = (0.0, 0.0);
        for (at, texel) in image.rgb.iter().enumerate() {
            assert!(texel[0] > 0.0 && texel[0] == texel[1] && texel[1] == texel[2]);
            let weight = row(at as u32 / image.width);
            sum += texel[0] * weight;
            weights += weight;
        }
        assert!((sum / weights - 1.0).abs() < 1e-3, "{}", sum / weights);
        // The key is in front on the left, where `turn` is between half and three quarters of a turn.
        let brightest =
            (0..image.rgb.len()).max_by(|&a, &b| image.rgb[a][0].total_cmp(&image.rgb[b][0]));
        let x = brightest.expect("some") as u32 % image.width;
        assert!((WIDTH / 2..3 * WIDTH / 4).contains(&x), "{x}");
    }
}
