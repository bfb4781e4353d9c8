//! Light in the Earth's atmosphere, for the sky of a look: single scattering by air and aerosols and absorption by ozone
//! are integrated along rays, and all further scattering is an isotropic series (Hillaire, "A Scalable and Production
//! Ready Sky and Atmosphere Rendering Technique", EGSR 2020, sections 5.5 and 6).
//!
//! Lengths are kilometres, coefficients 1/km. The three channels are 680, 550 and 440 nm, for which Bruneton and Neyret
//! ("Precomputed Atmospheric Scattering", EGSR 2008) give coefficients, and stand for red, green and blue.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

/// Radius of the ground.
const GROUND: f32 = 6360.0;
/// Radius beyond which there is no air.
const TOP: f32 = 6460.0;
/// Scattering by molecules at sea level (Bruneton and Neyret 2008, section 2.1) and the height in which it falls to 1/e.
const RAYLEIGH: Vec3 = Vec3::new(5.802e-3, 13.558e-3, 33.1e-3);
const RAYLEIGH_HEIGHT: f32 = 8.0;
/// Extinction by the aerosols of average air over land at 550 nm, the share of it that is scattering, and the mean cosine
/// of that (Hess, Koepke and Schult, "Optical Properties of Aerosols and Clouds: The Software Package OPAC", BAMS 79(5),
/// 1998, table 4); they fall to 1/e within this height.
const AEROSOL: f32 = 0.075;
const AEROSOL_ALBEDO: f32 = 0.925;
const AEROSOL_ASYMMETRY: f32 = 0.703;
const AEROSOL_HEIGHT: f32 = 1.2;
/// Extinction relative to 550 nm, which falls with the 1.3rd power of the wavelength (Angstrom, "The parameters of
/// atmospheric turbidity", Tellus 16(1), 1964).
const AEROSOL_COLOR: Vec3 = Vec3::new(0.759, 1.0, 1.337);
/// Absorption by ozone where it is densest: a layer that thins out linearly (Bruneton, "Precomputed Atmospheric
/// Scattering: a New Implementation", 2017; Hillaire 2020, table 1).
const OZONE: Vec3 = Vec3::new(0.650e-3, 1.881e-3, 0.085e-3);
const OZONE_CENTER: f32 = 25.0;
const OZONE_HALF_WIDTH: f32 = 15.0;

/// Lowest and highest place of a viewer above the ground.
const MIN_ALTITUDE: f32 = 0.002;
/// Entries of the tables: by height, and by direction.
const TRANSMITTANCE: (usize, usize) = (64, 256);
const SCATTERING: (usize, usize) = (32, 32);
/// Entries by the sun's cosine.
const SKYLIGHT: usize = 64;
/// Steps along a ray; to the top of the air, from its lowest place to each side.
const SUN_STEPS: u32 = 32;
const SERIES_STEPS: u32 = 20;
const VIEW_STEPS: u32 = 32;
/// Directions of the isotropic series.
const SERIES_DIRECTIONS: u32 = 64;
/// Directions by which the sky lights the ground: heights, and azimuths on one side of the sun.
const SKYLIGHT_DIRECTIONS: (u32, u32) = (8, 8);

/// Air above a ground, lit by a sun of irradiance 1 above the air.
#[derive(Debug)]
pub(super) struct Atmosphere {
    aerosol: f32,
    ground_albedo: Vec3,
    /// Optical depth up to the top of the air, by height and zenith angle; rows of one height. The share of light that comes through
    /// would bend too much between entries, where the air is thick.
    depth: Vec<Vec3>,
    /// Light that has been scattered at least twice, for each unit of scattering; rows of one height, by the sun's
    /// zenith angle.
    series: Vec<Vec3>,
    /// Logarithms of the irradiance of level ground by the sky without the sun, see [`Self::skylight_at`]. Empty until the tables
    /// that it comes from are there.
    skylight: Vec<Vec3>,
}

/// What is in the air at some height.
struct Medium {
    rayleigh: Vec3,
    aerosol: Vec3,
    extinction: Vec3,
}

impl Atmosphere {
    /// `aerosol` is a factor on the aerosols of average air over land.
    pub(super) fn new(aerosol: f32, ground_albedo: Vec3) -> Self {
        let mut air = Self {
            aerosol,
            ground_albedo,
            depth: Vec::new(),
            series: Vec::new(),
            skylight: Vec::new(),
        };
        let (rows, columns) = TRANSMITTANCE;
        air.depth = (0..rows * columns)
            .into_par_iter()
            .map(|i| {
                let (row, column) = (i / columns, i % columns);
                let (radius, cosine) = transmittance_entry(
                    row as f32 / (rows - 1) as f32,
                    column as f32 / (columns - 1) as f32,
                );
                air.integrated_depth(radius, cosine)
            })
            .collect();
        let (rows, columns) = SCATTERING;
        air.series = (0..rows * columns)
            .into_par_iter()
            .map(|i| {
                let (row, column) = (i / columns, i % columns);
                let height = row as f32 / (rows - 1) as f32 * (TOP - GROUND);
                let sun = 2.0 * column as f32 / (columns - 1) as f32 - 1.0;
                air.scattering_series(
                    GROUND + height.clamp(MIN_ALTITUDE, TOP - GROUND - 0.01),
                    sun,
                )
            })
            .collect();
        air.skylight = (0..SKYLIGHT)
            .into_par_iter()
            .map(|i| {
                let root = 2.0 * i as f32 / (SKYLIGHT - 1) as f32 - 1.0;
                let irradiance = air.integrated_skylight(root * root.abs());
                irradiance.max(Vec3::splat(1e-30)).map(f32::ln)
            })
            .collect();
        air
    }

    fn medium(&self, height: f32) -> Medium {
        let rayleigh = RAYLEIGH * (-height / RAYLEIGH_HEIGHT).exp();
        let dust = AEROSOL_COLOR * (AEROSOL * self.aerosol * (-height / AEROSOL_HEIGHT).exp());
        let ozone = (1.0 - (height - OZONE_CENTER).abs() / OZONE_HALF_WIDTH).max(0.0);
        Medium {
            rayleigh,
            aerosol: dust * AEROSOL_ALBEDO,
            extinction: rayleigh + dust + OZONE * ozone,
        }
    }

    /// The optical depth up to the top of the air. Steps grow with the third power from the lowest place to both sides: aerosols
    /// fall to 1/e within a hundredth of the air's height.
    fn integrated_depth(&self, radius: f32, cosine: f32) -> Vec3 {
        let length = to_top(radius, cosine);
        let lowest = (-radius * cosine).clamp(0.0, length);
        let depth = |way: f32| -> Vec3 {
            let along = |k: u32| way * (k as f32 / SUN_STEPS as f32).powi(3);
            let steps = 0..if way == 0.0 { 0 } else { SUN_STEPS };
            steps
                .map(|i| {
                    // Gauss's two places of a step.
                    let (from, to) = (along(i), along(i + 1));
                    let (middle, aside) = (0.5 * (from + to), 0.5 * (to - from) / 3f32.sqrt());
                    let at = |place: f32| {
                        let height = height_along(radius, cosine, lowest + place);
                        self.medium(height).extinction
                    };
                    0.5 * (to - from).abs() * (at(middle - aside) + at(middle + aside))
                })
                .sum()
        };
        depth(length - lowest) + depth(-lowest)
    }

    /// Share of the sun's light that arrives at a height from this zenith angle; none from below the horizon.
    pub(super) fn sunlight(&self, radius: f32, cosine: f32) -> Vec3 {
        if to_ground(radius, cosine).is_some() {
            return Vec3::ZERO;
        }
        self.transmittance_to_top(radius, cosine)
    }

    fn transmittance_to_top(&self, radius: f32, cosine: f32) -> Vec3 {
        let (v, u) = transmittance_place(radius, cosine);
        (-bilinear(&self.depth, TRANSMITTANCE, v, u)).exp()
    }

    fn series_at(&self, radius: f32, sun: f32) -> Vec3 {
        let v = (radius - GROUND) / (TOP - GROUND);
        bilinear(&self.series, SCATTERING, v, 0.5 * (sun + 1.0))
    }

    /// Irradiance of level ground by the sky without the sun. Entries are dense near the horizon, where light changes fast, and
    /// lie geometrically between each other: at dusk it falls by a factor with each degree.
    fn skylight_at(&self, sun: f32) -> Vec3 {
        if self.skylight.is_empty() {
            return Vec3::ZERO;
        }
        let root = sun.signum() * sun.abs().min(1.0).sqrt();
        let x = 0.5 * (root + 1.0) * (SKYLIGHT - 1) as f32;
        let low = (x as usize).min(SKYLIGHT - 2);
        let between = self.skylight[low].lerp(self.skylight[low + 1], x - low as f32);
        between.map(f32::exp)
    }

    fn integrated_skylight(&self, sun: f32) -> Vec3 {
        let to_sun = Vec3::new(0.0, sun, -(1.0 - sun * sun).max(0.0).sqrt());
        let (heights, azimuths) = SKYLIGHT_DIRECTIONS;
        let received = (0..heights * azimuths).map(|i| {
            let y = ((i / azimuths) as f32 + 0.5) / heights as f32;
            let azimuth = ((i % azimuths) as f32 + 0.5) / azimuths as f32 * PI;
            let across = (1.0 - y * y).sqrt();
            let direction = Vec3::new(across * azimuth.sin(), y, -across * azimuth.cos());
            y * self.seen(GROUND + MIN_ALTITUDE, direction, to_sun, SERIES_STEPS)
        });
        let sum: Vec3 = received.sum();
        sum * (2.0 * PI / (heights * azimuths) as f32)
    }

    /// Hillaire 2020, equations 5 to 10: light scattered twice, and the sum of the series whose ratio is the share that
    /// is scattered once more.
    fn scattering_series(&self, radius: f32, sun: f32) -> Vec3 {
        let to_sun = Vec3::new((1.0 - sun * sun).max(0.0).sqrt(), sun, 0.0);
        let (mut twice, mut again) = (Vec3::ZERO, Vec3::ZERO);
        for i in 0..SERIES_DIRECTIONS {
            // Evenly over the sphere, along a spiral.
            let y = 1.0 - (2.0 * i as f32 + 1.0) / SERIES_DIRECTIONS as f32;
            let turn = i as f32 * PI * (3.0 - 5f32.sqrt());
            let r = (1.0 - y * y).sqrt();
            let direction = Vec3::new(r * turn.cos(), y, r * turn.sin());
            let isotropic = 0.25 / PI;
            let (light, share) =
                self.march(radius, direction, to_sun, SERIES_STEPS, |_, m, sunlight| {
                    (m.rayleigh + m.aerosol) * isotropic * sunlight
                });
            twice += light / SERIES_DIRECTIONS as f32;
            again += share / SERIES_DIRECTIONS as f32;
        }
        twice / (Vec3::ONE - again)
    }

    /// Integrates what `scattered` gives, for a place's radius, what is there and the sunlight, along a ray and adds the
    /// light of the ground; also what is scattered of a light of 1 that comes from all around.
    fn march(
        &self,
        radius: f32,
        direction: Vec3,
        to_sun: Vec3,
        steps: u32,
        scattered: impl Fn((f32, f32), &Medium, Vec3) -> Vec3,
    ) -> (Vec3, Vec3) {
        let ground = to_ground(radius, direction.y);
        let length = ground.unwrap_or_else(|| to_top(radius, direction.y));
        let start = Vec3::Y * radius;
        let (mut light, mut share, mut passed) = (Vec3::ZERO, Vec3::ZERO, Vec3::ONE);
        let mut from = 0.0;
        for i in 0..steps {
            // Dense air is near: steps grow along the ray.
            let to = length * ((i + 1) as f32 / steps as f32).powi(2);
            let step = to - from;
            let p = start + direction * (0.5 * (from + to));
            let r = p.length().max(GROUND);
            let sun = p.dot(to_sun) / r;
            let medium = self.medium(r - GROUND);
            let source = scattered((r, sun), &medium, self.sunlight(r, sun));
            let through = (-medium.extinction * step).exp();
            // Exact for a source that is even along the step.
            let weight = passed * (Vec3::ONE - through) / medium.extinction.max(Vec3::splat(1e-12));
            light += weight * source;
            share += weight * (medium.rayleigh + medium.aerosol);
            passed *= through;
            from = to;
        }
        if ground.is_some() {
            let p = start + direction * length;
            let sun = p.dot(to_sun) / p.length();
            let matt = self.ground_albedo / PI;
            let direct = sun.max(0.0) * self.sunlight(GROUND + MIN_ALTITUDE, sun);
            light += passed * matt * (direct + self.skylight_at(sun));
        }
        (light, share)
    }

    /// Radiance that a viewer sees in a direction whose y is up.
    pub(super) fn radiance(&self, altitude: f32, direction: Vec3, to_sun: Vec3) -> Vec3 {
        self.seen(viewer_radius(altitude), direction, to_sun, VIEW_STEPS)
    }

    fn seen(&self, radius: f32, direction: Vec3, to_sun: Vec3, steps: u32) -> Vec3 {
        let cosine = direction.dot(to_sun).clamp(-1.0, 1.0);
        let air = 3.0 / (16.0 * PI) * (1.0 + cosine * cosine);
        let dust = aerosol_phase(cosine);
        let (light, _) = self.march(radius, direction, to_sun, steps, |(r, sun), m, sunlight| {
            sunlight * (m.rayleigh * air + m.aerosol * dust)
                + self.series_at(r, sun) * (m.rayleigh + m.aerosol)
        });
        light
    }
}

/// Radius of a viewer's place, by its altitude.
pub(super) fn viewer_radius(altitude: f32) -> f32 {
    GROUND + altitude.clamp(MIN_ALTITUDE, TOP - GROUND - 1.0)
}

/// The angle by which the horizon is lower than eye level, radians.
pub(super) fn horizon_dip(altitude: f32) -> f32 {
    (GROUND / viewer_radius(altitude)).acos()
}

/// Cornette and Shanks, "Physically reasonable analytic expression for the single-scattering phase function", 1992.
fn aerosol_phase(cosine: f32) -> f32 {
    let g = AEROSOL_ASYMMETRY;
    let scale = 3.0 / (8.0 * PI) * (1.0 - g * g) / (2.0 + g * g);
    scale * (1.0 + cosine * cosine) / (1.0 + g * g - 2.0 * g * cosine).powf(1.5)
}

/// Distance to the top of the air.
fn to_top(radius: f32, cosine: f32) -> f32 {
    let root = (radius * radius * (cosine * cosine - 1.0) + TOP * TOP).max(0.0);
    (-radius * cosine + root.sqrt()).max(0.0)
}

/// Distance to the ground, where the ray meets it.
fn to_ground(radius: f32, cosine: f32) -> Option<f32> {
    // The difference of squares as a product: both are large.
    let above = (radius - GROUND) * (radius + GROUND);
    let root = radius * radius * cosine * cosine - above;
    (cosine < 0.0 && root >= 0.0).then(|| (-radius * cosine - root.sqrt()).max(0.0))
}

fn height_along(radius: f32, cosine: f32, distance: f32) -> f32 {
    let squared = distance * (distance + 2.0 * radius * cosine);
    // sqrt(r^2 + squared) - r, without the loss of digits.
    let rise = squared / ((radius * radius + squared).max(0.0).sqrt() + radius);
    (radius - GROUND + rise).max(0.0)
}

/// Places in the table that are dense where light changes fast: near the horizon and near the ground (Bruneton 2017,
/// section "Transmittance texture").
fn transmittance_place(radius: f32, cosine: f32) -> (f32, f32) {
    let to_horizon = ((radius - GROUND) * (radius + GROUND)).max(0.0).sqrt();
    let (least, most) = (TOP - radius, to_horizon + horizon());
    let u = (to_top(radius, cosine) - least) / (most - least).max(1e-6);
    (to_horizon / horizon(), u)
}

fn transmittance_entry(v: f32, u: f32) -> (f32, f32) {
    let to_horizon = v * horizon();
    let radius = (to_horizon * to_horizon + GROUND * GROUND).sqrt();
    let (least, most) = (TOP - radius, to_horizon + horizon());
    let length = least + u * (most - least);
    let cosine = if length <= 0.0 {
        1.0
    } else {
        (horizon() * horizon() - to_horizon * to_horizon - length * length)
            / (2.0 * radius * length)
    };
    (radius, cosine.clamp(-1.0, 1.0))
}

/// Distance from the ground's horizon to the top of the air.
fn horizon() -> f32 {
    ((TOP - GROUND) * (TOP + GROUND)).sqrt()
}

fn bilinear(table: &[Vec3], (rows, columns): (usize, usize), v: f32, u: f32) -> Vec3 {
    let place = |x: f32, count: usize| {
        let x = x.clamp(0.0, 1.0) * (count - 1) as f32;
        let low = (x as usize).min(count - 2);
        (low, x - low as f32)
    };
    let ((row, fv), (column, fu)) = (place(v, rows), place(u, columns));
    let at = |r: usize, c: usize| table[r * columns + c];
    let top = at(row, column).lerp(at(row, column + 1), fu);
    let bottom = at(row + 1, column).lerp(at(row + 1, column + 1), fu);
    top.lerp(bottom, fv)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sunlight_loses_what_the_exact_integral_says() {
        for (aerosol, elevation) in [
            (1.0, 90.0),
            (1.0, 10.0),
            (1.0, 2.0),
            (5.0, 30.0),
            (5.0, 10.0f32),
        ] {
            let air = Atmosphere::new(aerosol, Vec3::ZERO);
            let radius = viewer_radius(0.0);
            let cosine = elevation.to_radians().sin();
            // Steps of 20 m and less, in double precision.
            let (r, c) = (f64::from(radius), f64::from(cosine));
            let length = f64::from(to_top(radius, cosine));
            let count = 50_000;
            let step = length / f64::from(count);
            let depth = (0..count).fold(glam::DVec3::ZERO, |sum, i| {
                let t = (f64::from(i) + 0.5) * step;
                let height = (r * r + t * t + 2.0 * r * t * c).sqrt() - f64::from(GROUND);
                sum + air.medium(height as f32).extinction.as_dvec3() * step
            });
            let found = -air.sunlight(radius, cosine).map(f32::ln);
            let off = (found / depth.as_vec3() - Vec3::ONE).abs();
            assert!(
                off.max_element() < 5e-3,
                "aerosol {aerosol}, {elevation} degrees: {found}, {depth}"
            );
        }
    }
}
