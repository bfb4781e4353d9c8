//! A clear sky with its sun, from a few numbers: a picture of the environment and a directional light.

use std::{
    f32::consts::{FRAC_PI_2, PI, TAU},
    sync::Arc,
};

use glam::Vec3;
use rayon::prelude::*;

use super::atmosphere::{Atmosphere, horizon_dip, viewer_radius};
use super::{Environment, FloatImage, LightKind, PunctualLight};

/// Texels of the picture.
const WIDTH: u32 = 512;
const HEIGHT: u32 = 256;

/// Irradiance of the sun above the air, on a surface that faces it, at intensity 1: a white matt surface would show a
/// radiance of 1. Multiply by 433 to have W/m² (the solar constant is 1361 W/m²).
pub const SOLAR_IRRADIANCE: f32 = PI;

/// A clear sky.
#[derive(Debug, Clone, PartialEq)]
pub struct Sky {
    /// Height of the sun's centre above eye level, degrees; negative after sunset.
    pub sun_elevation: f32,
    /// From where it shines, degrees: 0 is -Z, 90 is +X, as in a map whose top is -Z.
    pub sun_azimuth: f32,
    /// Aerosols relative to average air over land on a clear day: 0 is pure air, 5 the haze of a city.
    pub aerosol: f32,
    /// Metres above the sea.
    pub altitude: f32,
    /// Share of light that the ground around gives back.
    pub ground_albedo: Vec3,
    /// Whether the sun itself shines, too.
    pub sun: bool,
    /// Its angular diameter, degrees.
    pub sun_size: f32,
    /// Factor on all of it.
    pub intensity: f32,
}

impl Default for Sky {
    fn default() -> Self {
        Self {
            sun_elevation: 35.0,
            sun_azimuth: 0.0,
            aerosol: 1.0,
            altitude: 0.0,
            ground_albedo: Vec3::splat(0.3),
            sun: true,
            sun_size: 0.545,
            intensity: 1.0,
        }
    }
}

impl Sky {
    /// The sky's picture, and the sun where it is above the horizon and asked for.
    pub fn build(&self) -> (Environment, Option<PunctualLight>) {
        let air = Atmosphere::new(self.aerosol, self.ground_albedo);
        let altitude = self.altitude * 1e-3;
        let to_sun = self.to_sun();
        // The sky is symmetric: the picture begins and ends below the sun, and half of it is enough.
        let sun_ahead = towards(self.sun_elevation.to_radians(), 0.0);
        let half = |i: u32| {
            let u = ((i % (WIDTH / 2)) as f32 + 0.5) / WIDTH as f32;
            let v = ((i / (WIDTH / 2)) as f32 + 0.5) / HEIGHT as f32;
            // The environment's own orientation: direction (x, y, z) is at u = atan2(x, -z) / 2π, v = acos(y) / π.
            let direction = towards(FRAC_PI_2 - v * PI, u * TAU);
            let radiance = air.radiance(altitude, direction, sun_ahead) * SOLAR_IRRADIANCE;
            radiance.max(Vec3::ZERO).to_array()
        };
        let halves: Vec<[f32; 3]> = (0..WIDTH / 2 * HEIGHT).into_par_iter().map(half).collect();
        let rgb = halves
            .chunks_exact(WIDTH as usize / 2)
            .flat_map(|row| row.iter().chain(row.iter().rev()).copied())
            .collect();
        let environment = Environment::Image {
            image: Arc::new(FloatImage {
                width: WIDTH,
                height: HEIGHT,
                rgb,
            }),
            rotation: -self.sun_azimuth,
            intensity: self.intensity,
        };
        let irradiance = self.visible_part()
            * SOLAR_IRRADIANCE
            * self.intensity
            * air.sunlight(viewer_radius(altitude), self.mean_height().sin());
        let sun = PunctualLight {
            name: "sun".to_owned(),
            intensity: irradiance,
            position: Vec3::ZERO,
            direction: -to_sun,
            range: f32::INFINITY,
            kind: match self.sun_size > 0.0 {
                true => LightKind::Disk {
                    angular_diameter: self.sun_size.to_radians(),
                },
                false => LightKind::Directional,
            },
        };
        let shines = self.sun && irradiance.max_element() > 0.0;
        (environment, shines.then_some(sun))
    }

    fn to_sun(&self) -> Vec3 {
        towards(
            self.sun_elevation.to_radians(),
            self.sun_azimuth.to_radians(),
        )
    }

    /// Height of the sun's centre above the horizon in units of its radius, from -1 (just set) to 1.
    fn rise(&self) -> f32 {
        let above = self.sun_elevation.to_radians() + horizon_dip(self.altitude * 1e-3);
        (above / (0.5 * self.sun_size.to_radians()).max(1e-5)).clamp(-1.0, 1.0)
    }

    /// Share of the sun's disk that is above the horizon: a segment of the circle.
    fn visible_part(&self) -> f32 {
        let rise = self.rise();
        0.5 + (rise * (1.0 - rise * rise).max(0.0).sqrt() + rise.asin()) / PI
    }

    /// Height of the middle of what is visible of the disk, radians: its light goes through the air there.
    fn mean_height(&self) -> f32 {
        let radius = 0.5 * self.sun_size.to_radians();
        let hidden = 0.5 * (1.0 - self.rise());
        self.sun_elevation.to_radians() + radius * hidden
    }
}

fn towards(elevation: f32, azimuth: f32) -> Vec3 {
    let across = elevation.cos();
    Vec3::new(
        across * azimuth.sin(),
        elevation.sin(),
        -across * azimuth.cos(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(sun_elevation: f32) -> Sky {
        Sky {
            sun_elevation,
            ..Sky::default()
        }
    }

    fn luminance(c: Vec3) -> f32 {
        c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }

    fn radiance(sky: &Sky, elevation: f32, azimuth: f32) -> Vec3 {
        let air = Atmosphere::new(sky.aerosol, sky.ground_albedo);
        let direction = towards(elevation.to_radians(), azimuth.to_radians());
        air.radiance(sky.altitude * 1e-3, direction, sky.to_sun()) * SOLAR_IRRADIANCE
    }

    /// Irradiance of the sky alone, and of the sun, on a horizontal surface.
    fn irradiances(sky: &Sky) -> (Vec3, Vec3) {
        let (environment, sun) = sky.build();
        let Environment::Image { image, .. } = environment else {
            panic!("a sky is a picture")
        };
        let texel = (PI / HEIGHT as f32) * (TAU / WIDTH as f32);
        let diffuse = (0..HEIGHT / 2)
            .flat_map(|y| (0..WIDTH).map(move |x| (x, y)))
            .map(|(x, y)| {
                let polar = (y as f32 + 0.5) / HEIGHT as f32 * PI;
                let c = Vec3::from(image.rgb[(y * WIDTH + x) as usize]);
                (c * polar.sin() * polar.cos() * texel).as_dvec3()
            })
            .sum::<glam::DVec3>()
            .as_vec3();
        let direct = sun.map_or(Vec3::ZERO, |s| s.intensity * -s.direction.y);
        (diffuse, direct)
    }

    #[test]
    fn the_zenith_is_blue_while_the_sun_is_high() {
        for elevation in [30.0, 50.0, 70.0] {
            let zenith = radiance(&sky(elevation), 90.0, 0.0);
            assert!(zenith.z > 1.7 * zenith.x && zenith.z > zenith.y, "{zenith}");
        }
    }

    #[test]
    fn the_horizon_below_a_low_sun_is_red() {
        let low = sky(1.0);
        let horizon = radiance(&low, 1.0, 0.0);
        assert!(horizon.x > horizon.y && horizon.y > horizon.z, "{horizon}");
        let (_, sun) = low.build();
        let sun = sun.expect("above the horizon").intensity;
        assert!(sun.x > 1.5 * sun.y && sun.y > 2.0 * sun.z, "{sun}");
    }

    #[test]
    fn it_gets_darker_as_the_sun_sinks() {
        let mut before = f32::INFINITY;
        for elevation in [
            80.0, 60.0, 40.0, 20.0, 10.0, 5.0, 2.0, 0.0, -2.0, -5.0, -10.0,
        ] {
            let (diffuse, direct) = irradiances(&sky(elevation));
            let all = luminance(diffuse + direct);
            assert!(
                all < before && all > 0.0,
                "{elevation} degrees: {all}, {before}"
            );
            before = all;
        }
    }

    #[test]
    fn sun_and_sky_share_the_light_as_on_a_clear_day() {
        // Clear-sky measurements have a diffuse share of 8 to 25 % of the light on the ground at these heights (Iqbal,
        // "An Introduction to Solar Radiation", 1983, chapter 6), more in hazy air; the direct beam keeps 60 to 85 %.
        for elevation in [40.0, 60.0] {
            let clear = sky(elevation);
            let (diffuse, direct) = irradiances(&clear);
            let share = luminance(diffuse) / luminance(diffuse + direct);
            assert!(
                (0.08..0.25).contains(&share),
                "{elevation} degrees: {share}"
            );
            let (_, sun) = clear.build();
            let kept = luminance(sun.expect("it is up").intensity) / SOLAR_IRRADIANCE;
            assert!((0.6..0.85).contains(&kept), "{elevation} degrees: {kept}");
            // What arrives is no more than what comes in.
            let entered = elevation.to_radians().sin() * SOLAR_IRRADIANCE;
            assert!((diffuse + direct).max_element() < 1.05 * entered);
            let hazy = Sky {
                aerosol: 8.0,
                ..clear
            };
            let (diffuse, direct) = irradiances(&hazy);
            assert!(luminance(diffuse) / luminance(diffuse + direct) > share + 0.1);
        }
    }

    #[test]
    fn the_ground_is_as_bright_as_what_lies_on_it() {
        for elevation in [40.0, 10.0, 2.0, -2.0] {
            let sky = Sky {
                ground_albedo: Vec3::new(0.2, 0.3, 0.4),
                ..sky(elevation)
            };
            let (diffuse, direct) = irradiances(&sky);
            let matt = sky.ground_albedo / PI * (diffuse + direct);
            let ground = radiance(&sky, -90.0, 0.0);
            // Light of the sky is tabulated by the sun's height, from 64 directions.
            let error = (ground / matt - Vec3::ONE).abs().max_element();
            assert!(error < 0.1, "{elevation} degrees: {ground}, {matt}");
        }
    }

    #[test]
    fn every_texel_is_a_number_at_any_hour() {
        for (elevation, aerosol, altitude) in [
            (90.0, 1.0, 0.0),
            (0.1, 0.0, 0.0),
            (0.0, 1.0, 5000.0),
            (-0.2, 100.0, 0.0),
            (-18.0, 1.0, 1e9),
            (-90.0, 1.0, 0.0),
        ] {
            let sky = Sky {
                aerosol,
                altitude,
                ..sky(elevation)
            };
            let (environment, sun) = sky.build();
            let Environment::Image { image, .. } = environment else {
                panic!("a sky is a picture")
            };
            let is_light = |c: &f32| c.is_finite() && *c >= 0.0;
            assert!(image.rgb.iter().flatten().all(is_light), "{sky:?}");
            if let Some(sun) = sun {
                assert!(sun.intensity.to_array().iter().all(is_light), "{sky:?}");
            }
        }
        assert!(sky(-1.0).build().1.is_none());
    }

    #[test]
    fn the_sun_is_where_it_is_said_to_be() {
        let sky = Sky {
            sun_azimuth: 90.0,
            ..sky(30.0)
        };
        let (environment, sun) = sky.build();
        let to_sun = -sun.expect("it is up").direction;
        assert!((to_sun - Vec3::new(0.866_025_4, 0.5, 0.0)).length() < 1e-5);
        let Environment::Image {
            image, rotation, ..
        } = environment
        else {
            panic!("a sky is a picture")
        };
        let brightest = (0..image.rgb.len())
            .max_by(|&a, &b| image.rgb[a][1].total_cmp(&image.rgb[b][1]))
            .expect("there are texels");
        let (x, y) = (brightest as u32 % WIDTH, brightest as u32 / WIDTH);
        // Towards the horizon the air behind it is brighter, which draws the maximum down.
        assert!(y.abs_diff(HEIGHT / 3) <= 10, "{x}, {y}");
        // Where it is read from: u = azimuth + rotation, in turns.
        let u = (x as f32 + 0.5) / WIDTH as f32 - rotation / 360.0;
        assert!((u.rem_euclid(1.0) - 0.25).abs() < 0.01, "{x}, {y}");
    }
}
