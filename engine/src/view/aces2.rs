//! ACES 2.0's output transform for displays with the primaries of Rec.709 and a peak of 100 nits.
//!
//! The steps are those of the Academy's specification ("ACES Output Transforms", v2.0): colours are taken to lightness J,
//! colourfulness M and hue h of a colour appearance model (Hellwig and Fairchild's simplification of CAM16); a tone curve acts
//! on lightness, colourfulness is compressed along, and what the display can't show is drawn into its gamut along lines of one
//! hue. The limits for that are tables over the hue, found by search when the transform is first used. Peak and primaries are
//! constants here, so that what depends on them is, too.
//!
//! `aces2.wgsl` computes the same on the device, from [`Aces2::numbers`].

mod gamut;

use std::sync::LazyLock;

use glam::{DMat3, DVec3};

use super::chromatic::{AP0, AP1, Primaries, REC709};

/// Brightest scene-linear component of ACEScg that is told from brighter ones.
const BRIGHTEST: f64 = 1024.0;
/// Lightness of the display's white.
const J_MAX: f64 = 100.0;
/// Luminance of the display's white, nits.
const PEAK: f64 = 100.0;

/// Half saturation of the cones.
const CONE_OFFSET: f64 = 27.13;
const CONE_EXPONENT: f64 = 0.42;
/// Luminance of the adapting field, nits.
const ADAPTING_LUMINANCE: f64 = 100.0;

/// Primaries of the model's cones: the matrix of CAM16 seen as one of a colour space.
const CONES: Primaries = Primaries {
    red: [0.8336, 0.1735],
    green: [2.3854, -1.4659],
    blue: [0.087, -0.125],
    white: [0.333, 0.333],
};

/// Lightness, colourfulness, and hue in degrees.
#[derive(Debug, Clone, Copy)]
struct Jmh {
    j: f64,
    m: f64,
    h: f64,
}

/// The appearance model. Its response to white is the same for all spaces, as each is adapted to its own white.
#[derive(Debug)]
struct Model {
    /// Adapts cones to luminance, for colours in nits.
    adaptation: f64,
    /// Response of a cone to white.
    white: f64,
    /// Exponent of lightness over the achromatic response.
    exponent: f64,
    /// From responses of cones to the achromatic response, red-green and yellow-blue.
    opponent: DMat3,
    opponent_inverse: DMat3,
}

impl Model {
    fn new() -> Self {
        // CAM16's adaptation, and the exponent for a background of 20 nits in dim surround.
        let k = (1.0 / (5.0 * ADAPTING_LUMINANCE + 1.0)).powi(4);
        let field = 5.0 * ADAPTING_LUMINANCE;
        let factor = 0.2 * k * field + 0.1 * (1.0 - k).powi(2) * field.cbrt();
        let white = response(factor);
        let chroma = 400.0 * 43.0 * 0.9;
        let rows = [
            DVec3::new(2.0, 1.0, 0.05) / (3.05 * white),
            DVec3::new(1.0, -12.0 / 11.0, 1.0 / 11.0) * chroma,
            DVec3::new(1.0 / 9.0, 1.0 / 9.0, -2.0 / 9.0) * chroma,
        ];
        let opponent = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        Self {
            adaptation: factor / 100.0,
            white,
            exponent: 0.59 * (1.48 + 0.2_f64.sqrt()),
            opponent,
            opponent_inverse: opponent.inverse(),
        }
    }

    /// From linear components, 1 for 100 nits, to cones that are adapted to the space's white.
    fn cones(&self, space: &Primaries) -> DMat3 {
        let to_cones = CONES.to_xyz().inverse() * space.to_xyz();
        let white = to_cones * DVec3::ONE;
        DMat3::from_diagonal(100.0 * self.adaptation / white) * to_cones
    }

    /// Achromatic response and both opponents.
    fn opponents(&self, cones: DVec3) -> DVec3 {
        self.opponent * map(cones, response)
    }

    fn jmh(&self, cones: DVec3) -> Jmh {
        self.jmh_of(self.opponents(cones))
    }

    fn jmh_of(&self, opponents: DVec3) -> Jmh {
        let [a, red_green, yellow_blue] = opponents.to_array();
        if a <= 0.0 {
            return Jmh {
                j: 0.0,
                m: 0.0,
                h: 0.0,
            };
        }
        Jmh {
            j: self.lightness(a),
            m: red_green.hypot(yellow_blue),
            h: degrees(yellow_blue, red_green),
        }
    }

    fn cones_of(&self, color: Jmh) -> DVec3 {
        let (sin, cos) = color.h.to_radians().sin_cos();
        let opponents = DVec3::new(self.achromatic(color.j), color.m * cos, color.m * sin);
        map(self.opponent_inverse * opponents, stimulus)
    }

    fn lightness(&self, achromatic: f64) -> f64 {
        100.0 * achromatic.powf(self.exponent)
    }

    fn achromatic(&self, lightness: f64) -> f64 {
        (lightness / 100.0).powf(1.0 / self.exponent)
    }

    /// Lightness of a grey, in nits.
    fn lightness_of_grey(&self, nits: f64) -> f64 {
        self.lightness(response(nits * self.adaptation) / self.white)
    }

    /// The grey of an achromatic response, in nits.
    fn grey(&self, achromatic: f64) -> f64 {
        stimulus(achromatic * self.white) / self.adaptation
    }
}

fn map(v: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    DVec3::new(f(v.x), f(v.y), f(v.z))
}

/// Response of a cone, -1 to 1.
fn response(stimulus: f64) -> f64 {
    let power = stimulus.abs().powf(CONE_EXPONENT);
    (power / (CONE_OFFSET + power)).copysign(stimulus)
}

/// What makes a cone respond so.
fn stimulus(response: f64) -> f64 {
    let limited = response.abs().min(0.99);
    let power = CONE_OFFSET * limited / (1.0 - limited);
    power.powf(1.0 / CONE_EXPONENT).copysign(response)
}

/// Of an angle, 0 to 360.
fn degrees(y: f64, x: f64) -> f64 {
    let angle = y.atan2(x).to_degrees();
    if angle < 0.0 { angle + 360.0 } else { angle }
}

/// From scene luminance to that of the display, both in nits.
#[derive(Debug)]
struct Tonescale {
    half: f64,
    scale: f64,
}

impl Tonescale {
    const CONTRAST: f64 = 1.15;
    const FLARE: f64 = 0.04;
    /// Where a grey of 18 % comes to lie, of white.
    const GREY: f64 = 0.100_13;

    fn new() -> Self {
        // Before the flare is taken off, this is what leaves `y`.
        let before_flare = |y: f64| 0.5 * (y + (y * (y + 4.0 * Self::FLARE)).sqrt());
        let peak = before_flare(1.0);
        // The scene's value that hits the roof.
        let roof = 128.0 / peak;
        let power = Self::CONTRAST;
        let first = peak / (roof / (roof + 1.0)).powf(power);
        let grey = (before_flare(Self::GREY) / first).powf(1.0 / power);
        let shift = 0.18 / (peak * grey / (1.0 - grey));
        Self {
            half: shift * peak * 100.0,
            scale: peak / (roof / (roof + shift)).powf(power),
        }
    }

    fn apply(&self, nits: f64) -> f64 {
        let f = self.scale * (nits / (nits + self.half)).powf(Self::CONTRAST);
        (f * f / (f + Self::FLARE)).max(0.0) * PEAK
    }
}

/// How colourfulness follows lightness: constants of the specification for this peak.
mod chroma {
    pub(super) const SATURATION: f64 = 1.3;
    pub(super) const SATURATION_THRESHOLD: f64 = 0.005;
    pub(super) const COMPRESSION: f64 = 2.4;

    /// What colourfulness is measured in at a hue: the reach of Rec.2020 in lightness, as a series.
    pub(super) fn norm(cos: f64, sin: f64) -> f64 {
        let scale = (0.03379 * super::PEAK).powf(0.30596) - 0.45135;
        let cos2 = 2.0 * cos * cos - 1.0;
        let sin2 = 2.0 * cos * sin;
        let cos3 = 4.0 * cos * cos * cos - 3.0 * cos;
        let sin3 = 3.0 * sin - 4.0 * sin * sin * sin;
        let series = 77.12896 + 11.34072 * cos + 16.46899 * cos2 + 7.8838 * cos3 + 14.66441 * sin
            - 6.37224 * sin2
            + 9.19364 * sin3;
        series * scale
    }

    /// A toe: small values become smaller, those above the limit stay.
    pub(super) fn toe(x: f64, limit: f64, strength: f64, slope: f64) -> f64 {
        if x > limit {
            return x;
        }
        let slope = slope.max(0.001);
        let strength = (strength * strength + slope * slope).sqrt();
        let scale = (limit + strength) / (limit + slope);
        let b = scale * x - strength;
        0.5 * (b + (b * b + 4.0 * slope * scale * x).sqrt())
    }
}

/// The transform, with its tables.
#[derive(Debug)]
pub(super) struct Aces2 {
    model: Model,
    to_ap1: DMat3,
    cones_of_ap1: DMat3,
    display_of_cones: DMat3,
    tonescale: Tonescale,
    gamut: gamut::Gamut,
}

impl Aces2 {
    /// The transform, made when it is first asked for.
    pub(super) fn get() -> &'static Self {
        static ACES2: LazyLock<Aces2> = LazyLock::new(Aces2::new);
        &ACES2
    }

    fn new() -> Self {
        let model = Model::new();
        let tonescale = Tonescale::new();
        let middle = model.lightness_of_grey(Tonescale::GREY * 100.0);
        Self {
            to_ap1: REC709.to(&AP1),
            cones_of_ap1: model.cones(&AP0) * AP1.to(&AP0),
            display_of_cones: model.cones(&REC709).inverse(),
            gamut: gamut::Gamut::new(&model, middle),
            tonescale,
            model,
        }
    }

    /// From scene-linear Rec.709 to that of the display, 0 to 1.
    pub(super) fn apply(&self, rgb: DVec3) -> DVec3 {
        let ap1 = map(self.to_ap1 * rgb, |x| match x > 0.0 {
            true => x.min(BRIGHTEST),
            // What is no number, too.
            false => 0.0,
        });
        let model = &self.model;
        let opponents = model.opponents(self.cones_of_ap1 * ap1);
        let color = model.jmh_of(opponents);
        if color.j <= 0.0 {
            return DVec3::ZERO;
        }
        let nits = self.tonescale.apply(model.grey(opponents.x));
        let j = model.lightness_of_grey(nits);
        let reach = self.gamut.reach(color.h);
        let m = self.compressed_chroma(color, j, reach);
        let shown = self.gamut.compressed(Jmh { j, m, h: color.h }, reach);
        let display = self.display_of_cones * model.cones_of(shown);
        display.clamp(DVec3::ZERO, DVec3::ONE)
    }

    /// Colourfulness of a colour that has lightness `j` now.
    fn compressed_chroma(&self, color: Jmh, j: f64, reach: f64) -> f64 {
        if color.m <= 0.0 {
            return 0.0;
        }
        let (sin, cos) = color.h.to_radians().sin_cos();
        let norm = chroma::norm(cos, sin);
        let share = j / J_MAX;
        let rest = (1.0 - share).max(0.0);
        let power = 1.0 / self.model.exponent;
        let limit = share.powf(power) * reach / norm;
        let m = color.m * (j / color.j).powf(power) / norm;
        let slope = (share * share + chroma::SATURATION_THRESHOLD).sqrt();
        let m = limit - chroma::toe(limit - m, limit - 0.001, rest * chroma::SATURATION, slope);
        chroma::toe(m, limit, share * chroma::COMPRESSION, rest) * norm
    }

    /// All that depends on the specification's searches and matrices, in the order of `aces2.wgsl`: matrices row by row,
    /// scalars, then the tables over the hue.
    pub(super) fn numbers(&self) -> Vec<f32> {
        let matrices = [
            self.to_ap1,
            self.cones_of_ap1,
            self.model.opponent,
            self.model.opponent_inverse,
            self.display_of_cones,
        ];
        let rows = matrices.map(|matrix| matrix.transpose().to_cols_array());
        let scalars = [
            self.model.adaptation,
            self.model.white,
            self.model.exponent,
            self.tonescale.half,
            self.tonescale.scale,
            self.gamut.middle(),
        ];
        let numbers = rows.iter().flatten().chain(&scalars);
        let numbers = numbers.copied().chain(self.gamut.tables());
        numbers.map(|x| x as f32).collect()
    }
}
