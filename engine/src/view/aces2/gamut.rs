//! What a display can show at each hue, and how what it can't is drawn in.

use glam::{DMat3, DVec3};

use crate::view::chromatic::{AP1, REC709};

use super::{J_MAX, Jmh, Model};

/// Samples of the tables around the circle of hues; the first one is there twice.
const HUES: usize = 360;

/// How far cusps are rounded off.
const SMOOTH_CUSPS: f64 = 0.12;
/// How much farther out the smoothed cusps are put.
const SMOOTH_M: f64 = 0.27;
/// Share of the gamut that stays as it is at least.
const THRESHOLD: f64 = 0.75;
const FOCUS_DISTANCE: f64 = 1.35;
/// Exponent of the gamut's lower hull.
const LOWER_EXPONENT: f64 = 1.0 / 1.14;

/// Corners of the unit cube that are neither black nor white, in the order of their hues.
const CORNERS: [DVec3; 6] = [
    DVec3::new(1.0, 0.0, 0.0),
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(0.0, 1.0, 0.0),
    DVec3::new(0.0, 1.0, 1.0),
    DVec3::new(0.0, 0.0, 1.0),
    DVec3::new(1.0, 0.0, 1.0),
];

/// The gamut's hull at one hue.
#[derive(Debug, Clone, Copy)]
struct Hull {
    /// The most colourful point.
    j: f64,
    m: f64,
    /// Exponent of the upper hull.
    exponent: f64,
}

/// Tables over the hue, and what they were made with.
#[derive(Debug)]
pub(super) struct Gamut {
    /// 1 / the model's exponent.
    power: f64,
    /// Lightness of the display's middle grey.
    middle: f64,
    /// How colourful ACEScg gets at the lightness of white, at each degree.
    reach: Vec<f64>,
    /// Hues of the hulls: about a degree apart, with the corners of both gamuts among them, 0 to 360.
    hues: Vec<f64>,
    hulls: Vec<Hull>,
}

/// Lines of compression of one hue at one lightness: they meet behind the axis of greys.
struct Lines {
    focus: f64,
    gain: f64,
}

impl Lines {
    fn new(j: f64, hull: &Hull, middle: f64) -> Self {
        let blend = (1.3 - hull.j / J_MAX).min(1.0);
        let focus = hull.j + (middle - hull.j) * blend;
        let threshold = hull.j + (J_MAX - hull.j) * 0.3;
        let mut gain = J_MAX * FOCUS_DISTANCE;
        if j > threshold {
            // Near to white the lines get level.
            let steep = ((J_MAX - threshold) / (J_MAX - j).max(1e-4)).log10();
            gain *= steep * steep + 1.0;
        }
        Self { focus, gain }
    }

    /// Where the line through a point meets the axis of greys.
    fn axis(&self, j: f64, m: f64) -> f64 {
        let scaled = m / self.gain;
        let a = scaled / self.focus;
        if j < self.focus {
            let b = 1.0 - scaled;
            2.0 * j / (b + (b * b + 4.0 * a * j).sqrt())
        } else {
            let b = 1.0 + scaled + J_MAX * a;
            let c = J_MAX * scaled + j;
            2.0 * c / (b + (b * b - 4.0 * a * c).sqrt())
        }
    }

    /// Its slope, J over M.
    fn slope(&self, axis: f64) -> f64 {
        let room = if axis < self.focus {
            axis
        } else {
            J_MAX - axis
        };
        room * (axis - self.focus) / (self.focus * self.gain)
    }
}

/// About where a line meets the curve from the origin to a cusp: exactly so for the one whose axis is `reference`, through the
/// cusp itself.
fn crossing(axis: f64, slope: f64, exponent: f64, [j, m]: [f64; 2], reference: f64) -> f64 {
    let shifted = reference * (axis / reference).powf(exponent);
    shifted * m / (j - slope * m)
}

/// The smaller of two numbers, rounded off where they are near each other.
fn smooth_min(a: f64, b: f64, scale: f64) -> f64 {
    let width = SMOOTH_CUSPS * scale;
    let h = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - h * h * h * width / 6.0
}

impl Hull {
    /// Colourfulness where the line leaves the gamut.
    fn boundary(&self, lines: &Lines, axis: f64, slope: f64) -> f64 {
        let cusp_axis = lines.axis(self.j, self.m);
        let lower = crossing(axis, slope, LOWER_EXPONENT, [self.j, self.m], cusp_axis);
        // The upper hull is a lower one that hangs from white.
        let upper = crossing(
            J_MAX - axis,
            -slope,
            self.exponent,
            [J_MAX - self.j, self.m],
            J_MAX - cusp_axis,
        );
        smooth_min(lower, upper, self.m)
    }
}

/// Leaves what is below the threshold, and brings `reach` to the boundary.
fn remapped(m: f64, boundary: f64, reach: f64) -> f64 {
    let share = (boundary / reach).max(THRESHOLD);
    let threshold = share * boundary;
    if m <= threshold || share >= 1.0 {
        return m;
    }
    let (room, reach) = (boundary - threshold, reach - threshold);
    let scale = reach / (reach / room - 1.0);
    let x = (m - threshold) / scale;
    threshold + scale * x / (1.0 + x)
}

impl Gamut {
    pub(super) fn new(model: &Model, middle: f64) -> Self {
        let display = model.cones(&REC709);
        let reach = model.cones(&AP1);
        let corners = CORNERS.map(|corner| model.jmh(display * corner).h);
        let reach_corners = CORNERS.map(|corner| at_white(model, reach * corner).h);
        let hues = hues(&[corners, reach_corners].concat());
        let hulls = hues.iter().map(|&hue| {
            let mut hull = cusp(model, display, &corners, hue);
            hull.exponent = upper_exponent(model, display.inverse(), hue, &hull, middle);
            hull
        });
        let from_cones = reach.inverse();
        Self {
            power: 1.0 / model.exponent,
            middle,
            reach: (0..=HUES)
                .map(|degree| reach_at(model, from_cones, degree as f64))
                .collect(),
            hulls: hulls.collect(),
            hues,
        }
    }

    pub(super) fn middle(&self) -> f64 {
        self.middle
    }

    /// The tables, one after the other.
    pub(super) fn tables(&self) -> impl Iterator<Item = f64> {
        let hull = |of: fn(&Hull) -> f64| self.hulls.iter().map(of);
        let first = self.reach.iter().chain(&self.hues).copied();
        (first.chain(hull(|h| h.j)).chain(hull(|h| h.m))).chain(hull(|h| h.exponent))
    }

    /// How colourful ACEScg gets at a hue.
    pub(super) fn reach(&self, hue: f64) -> f64 {
        let below = (hue as usize).min(HUES - 1);
        let t = hue - below as f64;
        self.reach[below] + (self.reach[below + 1] - self.reach[below]) * t
    }

    fn hull(&self, hue: f64) -> Hull {
        let above = self.hues.partition_point(|&h| h < hue).clamp(1, HUES);
        let (a, b) = (&self.hulls[above - 1], &self.hulls[above]);
        let t = (hue - self.hues[above - 1]) / (self.hues[above] - self.hues[above - 1]);
        let mix = |a: f64, b: f64| a + (b - a) * t;
        Hull {
            j: mix(a.j, b.j),
            m: mix(a.m, b.m),
            exponent: mix(a.exponent, b.exponent),
        }
    }

    /// The colour drawn into the gamut; `reach` is that of its hue.
    pub(super) fn compressed(&self, color: Jmh, reach: f64) -> Jmh {
        let Jmh { j, m, h } = color;
        if m <= 0.0 || j > J_MAX {
            return Jmh { m: 0.0, ..color };
        }
        let hull = self.hull(h);
        let lines = Lines::new(j, &hull, self.middle);
        let axis = lines.axis(j, m);
        let slope = lines.slope(axis);
        let boundary = hull.boundary(&lines, axis, slope);
        if boundary <= 0.0 {
            return Jmh { m: 0.0, ..color };
        }
        let reach = crossing(axis, slope, self.power, [J_MAX, reach], J_MAX);
        let m = remapped(m, boundary, reach);
        let j = axis + m * slope;
        Jmh { j, m, h }
    }
}

/// A colour of the same cones' proportions that is as light as white.
fn at_white(model: &Model, cones: DVec3) -> Jmh {
    let is_light = |scale: f64| model.opponents(cones * scale).x >= 1.0;
    model.jmh(cones * searched([0.0, 1024.0], is_light))
}

/// Where a predicate becomes true between two numbers.
fn searched([mut low, mut high]: [f64; 2], is_beyond: impl Fn(f64) -> bool) -> f64 {
    // As many as single precision has bits, and some more.
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        match is_beyond(middle) {
            true => high = middle,
            false => low = middle,
        }
    }
    high
}

/// Hues with about a degree between, those of corners among them.
fn hues(corners: &[f64]) -> Vec<f64> {
    let mut corners = corners.to_vec();
    corners.sort_by(f64::total_cmp);
    let mut hues = Vec::with_capacity(HUES + 1);
    let mut last = (0, 0.0);
    let end = HUES as f64;
    let inner = corners.iter().map(|&hue| (hue.round() as usize, hue));
    // Of corners at one degree the first one counts.
    for (place, hue) in inner
        .filter(|(place, _)| *place < HUES)
        .chain([(HUES, end)])
    {
        let steps = place - last.0;
        if steps > 0 {
            hues.extend((0..steps).map(|i| last.1 + (hue - last.1) * i as f64 / steps as f64));
            last = (place, hue);
        }
    }
    hues.push(end);
    hues
}

/// The most colourful colour of the display at a hue: it is on an edge between two corners.
fn cusp(model: &Model, display: DMat3, corners: &[f64; 6], hue: f64) -> Hull {
    let ahead = |from: f64, to: f64| (to - from).rem_euclid(360.0);
    let is_on = |i: &usize| ahead(corners[*i], hue) < ahead(corners[*i], corners[(*i + 1) % 6]);
    let i = (0..6).find(is_on).unwrap_or_default();
    let edge = |t: f64| model.jmh(display * CORNERS[i].lerp(CORNERS[(i + 1) % 6], t));
    let wanted = ahead(corners[i], hue);
    let t = searched([0.0, 1.0], |t| {
        let there = ahead(corners[i], edge(t).h);
        // Rounding may put the edge's beginning before the corner.
        there < 350.0 && there > wanted
    });
    let Jmh { j, m, .. } = edge(t);
    Hull {
        j,
        m: m * (1.0 + SMOOTH_M * SMOOTH_CUSPS),
        exponent: 1.0,
    }
}

/// The exponent with which the upper hull is just outside of the display's gamut.
fn upper_exponent(model: &Model, from_cones: DMat3, hue: f64, cusp: &Hull, middle: f64) -> f64 {
    let probes = [0.01, 0.1, 0.5, 0.8, 0.99].map(|share| {
        let j = cusp.j + (J_MAX - cusp.j) * share;
        let lines = Lines::new(j, cusp, middle);
        let axis = lines.axis(j, cusp.m);
        let slope = lines.slope(axis);
        (lines, axis, slope)
    });
    let is_outside = |gamma: f64| {
        let hull = Hull {
            exponent: 1.0 / gamma,
            ..*cusp
        };
        probes.iter().all(|(lines, axis, slope)| {
            let m = hull.boundary(lines, *axis, *slope);
            let j = axis + slope * m;
            let shown = from_cones * model.cones_of(Jmh { j, m, h: hue });
            shown.max_element() > 1.0
        })
    };
    // In steps first: what is outside once need not stay so.
    let mut steps = (0..12).map(|i| 0.4 * f64::from(i));
    let low = steps.find(|low| is_outside(low + 0.4)).unwrap_or(4.8);
    1.0 / searched([low, low + 0.4], is_outside)
}

/// The largest colourfulness at white's lightness that has no negative component.
fn reach_at(model: &Model, from_cones: DMat3, hue: f64) -> f64 {
    let is_outside = |m: f64| {
        let color = Jmh {
            j: J_MAX,
            m,
            h: hue,
        };
        (from_cones * model.cones_of(color)).min_element() < 0.0
    };
    let mut steps = (0..26).map(|i| 50.0 * f64::from(i));
    let low = steps.find(|low| is_outside(low + 50.0)).unwrap_or(1250.0);
    searched([low, low + 50.0], is_outside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_go_around_once() {
        let model = Model::new();
        let gamut = Gamut::new(&model, 34.0);
        assert_eq!(gamut.hues.len(), HUES + 1);
        assert_eq!(gamut.hues.len(), gamut.hulls.len());
        assert!(gamut.hues.is_sorted_by(|a, b| a < b));
        for (hull, reach) in gamut.hulls.iter().zip(&gamut.reach) {
            assert!((20.0..100.0).contains(&hull.j), "{hull:?}");
            assert!((20.0..150.0).contains(&hull.m), "{hull:?}");
            assert!((0.2..5.0).contains(&hull.exponent), "{hull:?}");
            assert!(*reach > 50.0 && reach.is_finite(), "{reach}");
        }
        let ends = [0.0, 360.0].map(|hue| gamut.hull(hue));
        assert!((ends[0].m - ends[1].m).abs() < 1e-6);
    }

    #[test]
    fn corners_that_share_a_degree_leave_the_table_whole() {
        for corners in [&[][..], &[0.2, 0.4, 100.1, 100.3, 359.9]] {
            let hues = hues(corners);
            assert_eq!(hues.len(), HUES + 1);
            assert!(hues.is_sorted_by(|a, b| a < b));
        }
    }
}
