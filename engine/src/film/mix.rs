//! Lights mixed afterwards: the picture is the sum of what its groups of lights give, so that groups can be dimmed, tinted and
//! turned off without another sample.
//!
//! What is shown is `picture + sum over groups of (factor - 1) * group`. It is worked out on the film's whole numbers, with factors
//! as whole numbers, too: a group whose factor is 0 leaves nothing behind, and one whose factor is 1 changes no bit. `display/mix.wgsl` is the
//! twin on a device.

use std::collections::BTreeMap;

use scene::{LightGroups, UNGROUPED};

use super::layers::Layers;
use super::{Film, PICTURE_PLANES, words};

/// Bits behind the point of a factor. `mix.wgsl` has the same number.
const FACTOR_BITS: u32 = 24;

/// What the light of each group is multiplied by, by the group's name; [`UNGROUPED`] is that of no group.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LightMix {
    factors: BTreeMap<String, [f32; 3]>,
}

impl LightMix {
    /// Multiplies the light of a group by this, linear Rec.709, from now on: 0 is off, 1 as it is. From 0 to 256; what is no number is 1.
    pub fn set(&mut self, group: &str, factor: [f32; 3]) {
        self.factors.insert(group.to_owned(), factor);
    }

    /// The factors of a scene's groups, by their numbers. `None` where all are 1.
    pub fn of(&self, groups: &LightGroups) -> Option<GroupFactors> {
        let names = groups.names().iter().map(String::as_str);
        let of = |name: &str| self.factors.get(name).map_or(Multiple::NONE, Multiple::of);
        let multiples: Vec<_> = [UNGROUPED].into_iter().chain(names).map(of).collect();
        let is_neutral = multiples.iter().all(Multiple::is_none);
        (!is_neutral).then_some(GroupFactors { multiples })
    }
}

/// What the light of the groups of one scene is multiplied by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GroupFactors {
    /// By the number of the group.
    multiples: Vec<Multiple>,
}

impl GroupFactors {
    /// What is to be added to the picture of the group of a number.
    pub(crate) fn multiple(&self, group: usize) -> Multiple {
        self.multiples.get(group).copied().unwrap_or(Multiple::NONE)
    }
}

/// How many times a group's light is added to the picture that has it once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Multiple {
    /// Of red, green and blue, in units of 2^-24.
    pub(crate) magnitudes: [u32; 3],
    /// Whether it is taken away.
    pub(crate) is_negative: [bool; 3],
}

impl Multiple {
    const NONE: Self = Self {
        magnitudes: [0; 3],
        is_negative: [false; 3],
    };

    fn of(factor: &[f32; 3]) -> Self {
        let more = factor.map(|factor| match factor.is_nan() {
            true => 0.0,
            false => f64::from(factor.max(0.0)) - 1.0,
        });
        let unit = f64::from(1u32 << FACTOR_BITS);
        Self {
            // Beyond the range it is the largest one.
            magnitudes: more.map(|more| (more.abs() * unit).round() as u32),
            is_negative: more.map(|more| more < 0.0),
        }
    }

    /// Whether nothing is added.
    pub(crate) fn is_none(&self) -> bool {
        self.magnitudes == [0; 3]
    }

    /// So many times a channel's sum of 96 bits, rounded to the nearest unit.
    fn times(&self, channel: usize, [low, middle, high]: [u32; 3]) -> [u32; 3] {
        let sum = i128::from(high as i32) << 64 | i128::from(middle) << 32 | i128::from(low);
        let product = sum.unsigned_abs() * u128::from(self.magnitudes[channel]);
        let units = (product + (1 << (FACTOR_BITS - 1))) >> FACTOR_BITS;
        let is_negative = (sum < 0) != self.is_negative[channel];
        words(if is_negative {
            -(units as i128)
        } else {
            units as i128
        })
    }
}

impl Film {
    /// The picture alone, without other layers.
    #[must_use]
    pub fn picture(&self) -> Self {
        let planes = self.planes[..PICTURE_PLANES.len()].to_vec();
        Self::from_planes(self.width, self.height, Layers::default(), planes)
    }

    /// The picture alone, with its groups of lights multiplied by factors; groups that the film doesn't keep apart stay as they are. Its
    /// samples' squares, and so its error, are still those of the picture before.
    #[must_use]
    pub fn mixed(&self, factors: &GroupFactors) -> Self {
        let mut mixed = self.picture();
        for layer in self.layers.iter() {
            let Some(group) = layer.light_group() else {
                continue;
            };
            let multiple = factors.multiple(group);
            let Some(first) = self.layers.first_plane(layer) else {
                continue;
            };
            if multiple.is_none() {
                continue;
            }
            for (channel, plane) in self.planes[first..][..3].iter().enumerate() {
                for (pixel, &[low, middle, high, _]) in plane.iter().enumerate() {
                    let more = multiple.times(channel, [low, middle, high]);
                    mixed.add_words(pixel, 3 * channel, more);
                }
            }
        }
        mixed
    }
}

#[cfg(test)]
mod tests {
    use scene::LightSource;

    use super::super::layers::LIGHT_GROUPS;
    use super::*;

    fn groups() -> LightGroups {
        let mut groups = LightGroups::default();
        for name in ["key", "fill"] {
            let source = LightSource::Light(name);
            groups.assign(source, name).expect("room");
        }
        groups
    }

    /// One pixel with light of no group, of the first one, and, taken away by the pixel filter, of the second one.
    const LIGHT: [[f32; 3]; 3] = [[0.25, 0.5, 1.0], [3.0, 2.0, 0.125], [-0.5, 0.0, 1e-4]];

    fn film() -> Film {
        let scene = scene::Scene {
            light_groups: groups(),
            ..scene::Scene::default()
        };
        let layers = Layers::named([LIGHT_GROUPS]).expect("known");
        let mut film = Film::with_layers(1, 1, layers.of_scene(&scene));
        for sample in 0..2 {
            let sum = |c: usize| LIGHT.iter().map(|light| light[c]).sum();
            film.add_sample(0, std::array::from_fn(sum));
            film.add_surface(0, sample, |layer| {
                LIGHT[layer.light_group().expect("no other layer")]
            });
        }
        film
    }

    fn mix(factors: &[(&str, [f32; 3])]) -> Option<GroupFactors> {
        let mut mix = LightMix::default();
        for (name, factor) in factors {
            mix.set(name, *factor);
        }
        mix.of(&groups())
    }

    #[test]
    fn a_mix_of_ones_is_none() {
        let ones = [("key", [1.0; 3]), ("rest", [1.0; 3]), ("gone", [0.0; 3])];
        assert_eq!(mix(&ones), None);
        assert_eq!(mix(&[("key", [f32::NAN, 1.0, 1.0])]), None);
        let nothing = GroupFactors {
            multiples: Vec::new(),
        };
        assert_eq!(film().mixed(&nothing), film().picture());
    }

    #[test]
    fn factors_are_those_of_each_groups_light() {
        for factors in [
            [[1.0; 3], [0.0; 3], [1.0; 3]],
            [[0.0; 3], [1.0; 3], [0.0; 3]],
            [[2.5, 1.0, 0.125], [8.0, 0.1, 0.0], [0.3, 7.0, 1.5]],
        ] {
            let names = ["rest", "key", "fill"];
            let named: Vec<_> = names.into_iter().zip(factors).collect();
            let mixed = film().mixed(&mix(&named).expect("not all are 1"));
            assert!(mixed.layers().is_picture_alone());
            let sum = mixed.sum(0);
            for c in 0..3 {
                let light = LIGHT.iter().zip(&factors);
                let expected: f64 = light
                    .map(|(light, factor)| 2.0 * f64::from(light[c]) * f64::from(factor[c]))
                    .sum();
                // Factors are whole numbers of 2^-24.
                assert!((sum[c] - expected).abs() < 1e-6, "{} {expected}", sum[c]);
            }
        }
    }

    #[test]
    fn a_group_that_is_off_leaves_nothing_behind() {
        let dark = [("rest", [0.0; 3]), ("key", [0.0; 3]), ("fill", [0.0; 3])];
        let mixed = film().mixed(&mix(&dark).expect("off"));
        // Sums of numbers are rounded before they come to the film.
        assert!(
            mixed.sum(0).iter().all(|x| x.abs() < 1e-6),
            "{:?}",
            mixed.sum(0)
        );
        let off = mix(&[("key", [0.0; 3])]).expect("off").multiple(1);
        let [sum, minus] = [1i128 << 90 | 12345, -(1i128 << 90 | 12345)].map(words);
        assert_eq!(off.times(0, sum), minus);
        assert_eq!(off.times(0, minus), sum);
    }

    #[test]
    fn factors_beyond_the_range_are_the_largest() {
        let factors = mix(&[("key", [f32::INFINITY, 256.0, -3.0])]).expect("others");
        let multiple = factors.multiple(1);
        assert_eq!(multiple.magnitudes, [u32::MAX, 255 << 24, 1 << 24]);
        assert_eq!(multiple.is_negative, [false, false, true]);
    }
}
