//! Primaries and whites as matrices: conversions between colour spaces, adaptation of one white to another, white balance.

use glam::{DMat3, DVec2, DVec3};
use scene::view::WhiteBalance;

/// CIE 1931 chromaticities of a colour space.
pub(super) struct Primaries {
    pub red: [f64; 2],
    pub green: [f64; 2],
    pub blue: [f64; 2],
    pub white: [f64; 2],
}

const D65: [f64; 2] = [0.3127, 0.3290];
/// That of ACES, near to D60 (SMPTE ST 2065-1).
const ACES_WHITE: [f64; 2] = [0.32168, 0.33767];

/// ITU-R BT.709.
pub(super) const REC709: Primaries = Primaries {
    red: [0.64, 0.33],
    green: [0.3, 0.6],
    blue: [0.15, 0.06],
    white: D65,
};

/// FilmLight's E-Gamut.
pub(super) const E_GAMUT: Primaries = Primaries {
    red: [0.8, 0.3177],
    green: [0.18, 0.9],
    blue: [0.065, -0.0805],
    white: D65,
};

/// ACES2065-1 (SMPTE ST 2065-1).
pub(super) const AP0: Primaries = Primaries {
    red: [0.7347, 0.2653],
    green: [0.0, 1.0],
    blue: [0.0001, -0.077],
    white: ACES_WHITE,
};

/// ACEScg (Academy S-2014-004).
pub(super) const AP1: Primaries = Primaries {
    red: [0.713, 0.293],
    green: [0.165, 0.83],
    blue: [0.128, 0.044],
    white: ACES_WHITE,
};

impl Primaries {
    /// From linear components to CIE XYZ; white has Y = 1.
    pub(super) fn to_xyz(&self) -> DMat3 {
        let unscaled = DMat3::from_cols(xyz(self.red), xyz(self.green), xyz(self.blue));
        let scale = unscaled.inverse() * xyz(self.white);
        unscaled * DMat3::from_diagonal(scale)
    }

    /// From this space to another one; white becomes white.
    pub(super) fn to(&self, other: &Self) -> DMat3 {
        let adaptation = adaptation(xyz(self.white), xyz(other.white));
        other.to_xyz().inverse() * adaptation * self.to_xyz()
    }
}

/// XYZ of a chromaticity, with Y = 1.
fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// What a cone's response is multiplied by at most.
const MOST_GAIN: f64 = 50.0;

/// Cone responses of the Bradford transform (K. M. Lam, 1985).
fn bradford() -> DMat3 {
    DMat3::from_cols_array(&[
        0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296,
    ])
}

/// From XYZ seen under one white to XYZ seen under another.
fn adaptation(from: DVec3, to: DVec3) -> DMat3 {
    let cones = bradford();
    let (from, to) = (cones * from, cones * to);
    // Light that is redder and greener than any has no blue to be balanced.
    let gains = to / from.max(to / MOST_GAIN);
    cones.inverse() * DMat3::from_diagonal(gains) * cones
}

/// The matrix on linear Rec.709 that makes light of that colour white.
pub(super) fn balance(white: &WhiteBalance) -> DMat3 {
    let to_xyz = REC709.to_xyz();
    to_xyz.inverse() * adaptation(light(white), xyz(D65)) * to_xyz
}

/// XYZ of the light that is to be white, with Y = 1.
fn light(white: &WhiteBalance) -> DVec3 {
    let temperature = f64::from(white.temperature);
    let at = planckian(temperature);
    // What is off the locus is so at a right angle in this diagram: that defines a correlated colour temperature.
    let step = temperature * 1e-3;
    let along = (planckian(temperature + step) - planckian(temperature - step)).normalize();
    // Temperatures rise towards blue, to smaller u: green is on the left hand then.
    let up = DVec2::new(along.y, -along.x);
    let uv = at + up * f64::from(white.tint) / 3000.0;
    let scale = 1.0 / (2.0 * uv.x - 8.0 * uv.y + 4.0);
    xyz([3.0 * uv.x * scale, 2.0 * uv.y * scale])
}

/// CIE 1960 (u, v) of a black body between 1000 K and 15000 K, and near enough above (M. Krystek, "An algorithm to calculate
/// correlated colour temperature", 1985).
fn planckian(t: f64) -> DVec2 {
    let u = (0.860_117_757 + 1.541_182_54e-4 * t + 1.286_412_12e-7 * t * t)
        / (1.0 + 8.424_202_35e-4 * t + 7.081_451_63e-7 * t * t);
    let v = (0.317_398_726 + 4.228_062_45e-5 * t + 4.204_816_91e-8 * t * t)
        / (1.0 - 2.897_418_16e-5 * t + 1.614_560_53e-7 * t * t);
    DVec2::new(u, v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rec709_has_the_published_matrix() {
        // IEC 61966-2-1, annex F.
        let published = [
            0.4124, 0.2126, 0.0193, 0.3576, 0.7152, 0.1192, 0.1805, 0.0722, 0.9505,
        ];
        for (a, b) in REC709.to_xyz().to_cols_array().iter().zip(published) {
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
        let back = AP1.to(&REC709) * REC709.to(&AP1);
        assert!(back.abs_diff_eq(DMat3::IDENTITY, 1e-12));
        assert!((REC709.to(&AP0) * DVec3::ONE).abs_diff_eq(DVec3::ONE, 1e-12));
    }

    #[test]
    fn daylight_is_all_but_white() {
        let matrix = balance(&WhiteBalance::default());
        assert!(matrix.abs_diff_eq(DMat3::IDENTITY, 5e-3), "{matrix}");
    }

    #[test]
    fn light_of_the_colour_becomes_white_and_keeps_its_luminance() {
        let mut temperature = *WhiteBalance::TEMPERATURES.start();
        while temperature <= *WhiteBalance::TEMPERATURES.end() {
            for tint in [-100.0, 0.0, 10.0, 100.0] {
                let white = WhiteBalance { temperature, tint };
                let seen = REC709.to_xyz().inverse() * light(&white);
                let balanced = balance(&white) * seen;
                let is_white = balanced.abs_diff_eq(DVec3::ONE, 1e-9);
                // Below, there is no light of that green.
                let has_blue = tint <= 10.0 || temperature > 3500.0;
                assert!(is_white || !has_blue, "{white:?} {balanced}");
                assert!(balance(&white).is_finite(), "{white:?}");
            }
            temperature *= 1.1;
        }
    }

    #[test]
    fn a_warm_light_makes_the_picture_cooler_and_a_green_one_more_magenta() {
        let grey = |temperature, tint| balance(&WhiteBalance { temperature, tint }) * DVec3::ONE;
        let warm = grey(3200.0, 10.0);
        assert!(warm.x < warm.y && warm.y < warm.z, "{warm}");
        let green = grey(6500.0, 60.0);
        assert!(green.y < green.x && green.y < green.z, "{green}");
    }
}
