//! Shadows on shadow catchers: how much of the light that lamps and environment send straight onto them is kept from them.
//!
//! The light sample of each first surface that is a catcher is counted twice, as if nothing were in its way and as it arrives, both
//! without the weight that other samples of the same light leave it. A pixel's shadow is what the sums say, not what single
//! samples do: the share of light, not of lamps.

use super::{Film, Layer, layers, signed};

/// Planes of the layers that are kept for shadows, in their order.
const PLANES: usize = 10;
const LIGHT: usize = 1;
const SHADOWLESS: usize = 4;
const ARRIVED: usize = 7;

/// What is kept of one pixel, as means of its samples.
pub(super) struct Caught {
    /// Share of the samples that meet a shadow catcher: with negative weights of the filter it may leave 0 to 1, as that of all surfaces
    /// does.
    weight: f64,
    /// Radiance of the catchers.
    pub(super) light: [f64; 3],
    shadowless: [f64; 3],
    arrived: [f64; 3],
}

impl Film {
    /// What a pixel has of shadow catchers; `None` where the film doesn't tell.
    pub(super) fn caught(&self, pixel: usize) -> Option<Caught> {
        let first = self.layers.first_plane(Layer::named(layers::CAUGHT)?)?;
        let planes = self.planes.get(first..first + PLANES)?;
        let n = f64::from(self.samples(pixel).max(1));
        let mean = |plane: usize| {
            let [low, middle, high, _] = planes[plane][pixel];
            signed([low, middle, high]) / n
        };
        let color = |plane| std::array::from_fn(|channel| mean(plane + channel));
        Some(Caught {
            weight: mean(0),
            light: color(LIGHT),
            shadowless: color(SHADOWLESS),
            arrived: color(ARRIVED),
        })
    }

    /// By what a background is to be multiplied to have the shadows of a pixel's catchers, channel by channel: 0 to 1.
    pub(super) fn shadow_factor(&self, pixel: usize) -> [f32; 3] {
        self.caught(pixel)
            .map_or([1.0; 3], |caught| caught.factor())
    }

    /// How much of a pixel the shadows on its catchers take: 0 to 1.
    pub(super) fn shadow(&self, pixel: usize) -> f32 {
        self.caught(pixel)
            .map_or(0.0, |caught| caught.shadow() as f32)
    }
}

impl Caught {
    fn factor(&self) -> [f32; 3] {
        let kept = |c| kept(self.shadowless[c], self.arrived[c]);
        std::array::from_fn(|c| (1.0 - self.share() * kept(c)) as f32)
    }

    fn shadow(&self) -> f64 {
        self.share() * self.kept()
    }

    /// What of the catchers isn't seen, weighed as all surfaces are, so that nothing is left of both where there is no shadow.
    pub(super) fn hidden(&self) -> f64 {
        self.weight - self.weight * self.kept()
    }

    fn share(&self) -> f64 {
        self.weight.clamp(0.0, 1.0)
    }

    /// By the brightness of what is kept.
    fn kept(&self) -> f64 {
        let brightness = |[r, g, b]: [f64; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        kept(brightness(self.shadowless), brightness(self.arrived))
    }
}

/// Where no light would fall there is no shadow.
fn kept(shadowless: f64, arrived: f64) -> f64 {
    match shadowless > 0.0 {
        true => (1.0 - arrived / shadowless).clamp(0.0, 1.0),
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Layers;

    #[test]
    fn what_a_filter_weighs_by_more_than_all_is_covered_once() {
        let names = ["environment", "alpha", layers::SHADOW_CATCHER];
        let mut film = Film::with_layers(3, 1, Layers::named(names).expect("known"));
        // A catcher without a shadow, one in half a shadow, and something else: each by a weight of 1.25.
        for (pixel, caught, arrived) in [(0, 1.25, 1.0), (1, 1.25, 0.5), (2, 0.0, 0.0)] {
            film.add_sample(pixel, [1.25; 3]);
            film.add_surface(pixel, 0, |layer| match layer.name {
                "alpha" => [1.25, 0.0, 0.0],
                layers::CAUGHT => [caught, 0.0, 0.0],
                "caught_light" => [caught; 3],
                "caught_shadowless" => [1.0; 3],
                "caught_arrived" => [arrived; 3],
                _ => [0.0; 3],
            });
        }
        assert_eq!(film.alpha(), Some(vec![0.0, 0.625, 1.0]));
        assert_eq!(film.foreground().expect("gathered")[2], [1.0; 3]);
        assert_eq!(film.shadow(1), 0.5);
    }
}
