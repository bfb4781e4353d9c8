//! Values between the keys of an animation (glTF 2.0, appendix C).

use super::document::Document;
use crate::import::error::Fault;
use glam::DQuat;

/// By what share of itself a moment may come before a key and still be the key's: times of keys are rounded to `f32`, by up to 6e-8,
/// and a frame's are not, so that every other key at a frame would be missed by it.
const SAME_TIME: f64 = 2e-7;

/// How values lie between two keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Interpolation {
    Step,
    Linear,
    /// Hermite splines; each key has an in-tangent, a value and an out-tangent.
    CubicSpline,
}

impl Interpolation {
    /// Elements of the output for each key.
    fn elements(self) -> usize {
        match self {
            Self::Step | Self::Linear => 1,
            Self::CubicSpline => 3,
        }
    }
}

/// Keys with their values.
#[derive(Debug)]
pub(super) struct Sampler {
    /// Seconds; finite, never descending, at least one.
    times: Vec<f32>,
    /// `width` numbers for each element; finite.
    values: Vec<f32>,
    width: usize,
    interpolation: Interpolation,
}

impl Sampler {
    /// Reads keys from the accessor `input`, and values of `width` numbers from `output`: of vectors with so many components, or of
    /// so many scalars each.
    pub(super) fn read(
        document: &Document,
        [input, output]: [usize; 2],
        interpolation: Interpolation,
        width: usize,
        is_scalar: bool,
    ) -> Result<Self, Fault> {
        let keys = document.accessor(input)?;
        let values = document.accessor(output)?;
        let components = if is_scalar { 1 } else { width };
        if keys.components() != 1 || values.components() != components {
            return Err(format!(
                "its values have {} components and its times {}; {components} and 1 are needed",
                values.components(),
                keys.components()
            ));
        }
        let wanted = u64::from(keys.count())
            * (interpolation.elements() * if is_scalar { width } else { 1 }) as u64;
        if keys.count() == 0 || u64::from(values.count()) != wanted {
            return Err(format!(
                "has {} times and {} values; {wanted} values are needed, and at least one time",
                keys.count(),
                values.count()
            ));
        }
        let numbers = u64::from(keys.count()) + wanted * components as u64;
        document.budget.take(numbers, 4 * 4)?;
        let times: Vec<f32> = keys.all::<1>().into_iter().flatten().collect();
        let values: Vec<f32> = (values.all::<4>().iter())
            .flat_map(|value| &value[..components])
            .copied()
            .collect();
        Self::new(times, values, width, interpolation)
    }

    fn new(
        times: Vec<f32>,
        values: Vec<f32>,
        width: usize,
        interpolation: Interpolation,
    ) -> Result<Self, Fault> {
        if !times.iter().chain(&values).all(|number| number.is_finite()) {
            return Err("has a time or a value that is not finite".into());
        }
        if let Some(at) = times.windows(2).position(|pair| pair[0] > pair[1]) {
            return Err(format!("has times that go back, at key {}", at + 1));
        }
        Ok(Self {
            times,
            values,
            width,
            interpolation,
        })
    }

    /// Times of the first and the last key.
    pub(super) fn range(&self) -> [f32; 2] {
        [self.times[0], self.times[self.times.len() - 1]]
    }

    /// The numbers at a time; those of the first or the last key outside of them.
    pub(super) fn at(&self, seconds: f64) -> Vec<f64> {
        self.between(seconds, |a, b, s| {
            (0..self.width).map(|i| a[i] + (b[i] - a[i]) * s).collect()
        })
    }

    /// The rotation at a time, of unit length; `None` where the file has none there.
    pub(super) fn rotation_at(&self, seconds: f64) -> Option<DQuat> {
        let unit = |q: &[f64]| {
            let q = DQuat::from_xyzw(q[0], q[1], q[2], q[3]);
            let length = q.length();
            (length > 1e-9 && length.is_finite()).then(|| q / length)
        };
        let mixed = self.between(seconds, |a, b, s| match (unit(a), unit(b)) {
            (Some(a), Some(b)) => slerp(a, b, s).to_array().to_vec(),
            (Some(q), None) | (None, Some(q)) => q.to_array().to_vec(),
            (None, None) => vec![0.0; 4],
        });
        unit(&mixed)
    }

    /// As [`Self::at`], with `mix` for the linear interpolation between two values.
    fn between(&self, seconds: f64, mix: impl FnOnce(&[f64], &[f64], f64) -> Vec<f64>) -> Vec<f64> {
        let reached = seconds + SAME_TIME * seconds.abs();
        let next = self
            .times
            .partition_point(|&time| f64::from(time) <= reached);
        let last = self.times.len() - 1;
        if next == 0 {
            return self.value(0);
        }
        if next > last {
            return self.value(last);
        }
        let (before, from) = (next - 1, f64::from(self.times[next - 1]));
        // They differ: the one is reached, the other isn't.
        let duration = f64::from(self.times[next]) - from;
        let s = ((seconds - from) / duration).max(0.0);
        match self.interpolation {
            Interpolation::Step => self.value(before),
            Interpolation::Linear => mix(&self.value(before), &self.value(next), s),
            Interpolation::CubicSpline => {
                let [a, b] = [self.value(before), self.value(next)];
                let (leaving, arriving) = (self.element(3 * before + 2), self.element(3 * next));
                let (s2, s3) = (s * s, s * s * s);
                (0..self.width)
                    .map(|i| {
                        (2.0 * s3 - 3.0 * s2 + 1.0) * a[i]
                            + duration * (s3 - 2.0 * s2 + s) * leaving[i]
                            + (3.0 * s2 - 2.0 * s3) * b[i]
                            + duration * (s3 - s2) * arriving[i]
                    })
                    .collect()
            }
        }
    }

    /// The value of a key.
    fn value(&self, key: usize) -> Vec<f64> {
        match self.interpolation {
            Interpolation::Step | Interpolation::Linear => self.element(key),
            Interpolation::CubicSpline => self.element(3 * key + 1),
        }
    }

    fn element(&self, element: usize) -> Vec<f64> {
        let start = element * self.width;
        let numbers = &self.values[start..start + self.width];
        numbers.iter().map(|&number| f64::from(number)).collect()
    }
}

/// Spherical linear interpolation the short way (glTF 2.0, appendix C.4).
fn slerp(from: DQuat, to: DQuat, s: f64) -> DQuat {
    let dot = from.dot(to);
    let to = if dot < 0.0 { -to } else { to };
    let angle = dot.abs().min(1.0).acos();
    let sine = angle.sin();
    // Rotations that are nearly the same lie on a line.
    if sine < 1e-9 {
        return from * (1.0 - s) + to * s;
    }
    from * ((angle * (1.0 - s)).sin() / sine) + to * ((angle * s).sin() / sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampler(times: &[f32], values: &[f32], width: usize, how: Interpolation) -> Sampler {
        Sampler::new(times.to_vec(), values.to_vec(), width, how).expect("these are keys")
    }

    #[test]
    fn values_lie_between_their_keys_and_stand_still_outside() {
        let linear = sampler(
            &[1.0, 2.0, 4.0],
            &[0.0, 10.0, 5.0, -10.0, 9.0, 0.0],
            2,
            Interpolation::Linear,
        );
        for (time, wanted) in [
            (-3.0, [0.0, 10.0]),
            (1.0, [0.0, 10.0]),
            (1.25, [1.25, 5.0]),
            (2.0, [5.0, -10.0]),
            (3.5, [8.0, -2.5]),
            (4.0, [9.0, 0.0]),
            (f64::MAX, [9.0, 0.0]),
        ] {
            assert_eq!(linear.at(time), wanted, "{time}");
        }
        let step = sampler(&[1.0, 2.0], &[3.0, 4.0], 1, Interpolation::Step);
        for (time, wanted) in [(0.0, 3.0), (1.99, 3.0), (2.0, 4.0), (9.0, 4.0)] {
            assert_eq!(step.at(time), [wanted], "{time}");
        }
    }

    /// As exporters write them: the number of the frame by the rate, rounded to what the file holds.
    #[test]
    fn keys_at_frames_are_reached_at_these_frames() {
        for rate in [24.0, 25.0, 30.0, 23.976, 60.0] {
            let times: Vec<f32> = (0..3000).map(|k| (f64::from(k) / rate) as f32).collect();
            let values: Vec<f32> = (0..3000).map(|k| k as f32).collect();
            let of = |how| sampler(&times, &values, 1, how);
            let [step, linear] = [Interpolation::Step, Interpolation::Linear].map(of);
            for k in 0..3000 {
                let k = f64::from(k);
                assert_eq!(step.at(k / rate), [k], "at a rate of {rate}");
                assert!((linear.at(k / rate)[0] - k).abs() < 0.002, "{k} at {rate}");
                // Halfway to the next one it isn't reached.
                assert_eq!(step.at((k + 0.5) / rate), [k], "at a rate of {rate}");
            }
        }
    }

    #[test]
    fn splines_follow_their_tangents() {
        // In-tangent, value, out-tangent for two keys, two seconds apart.
        let keys = [7.0, 1.0, 2.0, -1.0, 5.0, 7.0];
        let spline = sampler(&[1.0, 3.0], &keys, 1, Interpolation::CubicSpline);
        assert_eq!(spline.at(0.0), [1.0]);
        assert_eq!(spline.at(4.0), [5.0]);
        // By hand, at s = 1/2: (1 + 5) / 2 + 2 (2 / 8 - -1 / 8).
        assert_eq!(spline.at(2.0), [3.75]);
        // At s = 1/4: 27/32 + 2 * 2 * 9/64 + 5 * 5/32 - 2 * -3/64.
        assert!(
            (spline.at(1.5)[0] - (27.0 / 32.0 + 36.0 / 64.0 + 25.0 / 32.0 + 6.0 / 64.0)).abs()
                < 1e-12
        );
    }

    #[test]
    fn rotations_turn_evenly_and_the_short_way() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        // A quarter turn about x, of which the second key has the other sign.
        let turn = [0.0, 0.0, 0.0, 1.0, -half, 0.0, 0.0, -half];
        let sampler = sampler(&[0.0, 3.0], &turn, 4, Interpolation::Linear);
        for share in [0.0, 1.0 / 3.0, 0.5, 1.0] {
            let found = sampler.rotation_at(3.0 * share).expect("a rotation");
            let wanted = DQuat::from_rotation_x(share * std::f64::consts::FRAC_PI_2);
            assert!(found.dot(wanted).abs() > 1.0 - 1e-7, "{share}: {found}");
        }
        let nowhere = [0.0; 4];
        let nowhere = Sampler::new(vec![0.0], nowhere.to_vec(), 4, Interpolation::Linear);
        assert_eq!(nowhere.expect("numbers").rotation_at(0.0), None);
    }

    #[test]
    fn keys_that_make_no_sense_are_refused() {
        let refused = |times: &[f32], values: &[f32]| {
            Sampler::new(times.to_vec(), values.to_vec(), 1, Interpolation::Linear).unwrap_err()
        };
        assert!(refused(&[0.0, 2.0, 1.0], &[0.0; 3]).contains("go back, at key 2"));
        assert!(refused(&[f32::NAN], &[0.0]).contains("not finite"));
        assert!(refused(&[0.0], &[f32::INFINITY]).contains("not finite"));
        // Two keys at one time are a jump.
        let jump = sampler(
            &[0.0, 1.0, 1.0, 2.0],
            &[0.0, 1.0, 5.0, 5.0],
            1,
            Interpolation::Linear,
        );
        assert_eq!((jump.at(0.5), jump.at(1.0)), (vec![0.5], vec![5.0]));
    }
}
