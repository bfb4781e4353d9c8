//! Parts of the sky, and how light samples are spread over them: by what each sends, and how much of that a surface receives.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, dvec3};

/// Columns and rows of parts: as in `shared/sky_parts.wgsl`.
pub(crate) const SKY_PARTS: [u32; 2] = [32, 16];
/// Parts.
pub(crate) const PARTS: usize = (SKY_PARTS[0] * SKY_PARTS[1]) as usize;
/// Steps of the grid of normals by which the sky is sampled where nothing else is known: `FACING_STEPS`.
pub(crate) const FACING_STEPS: u32 = 16;
/// What normals between those of that grid receive beyond them.
const BETWEEN: Between = Between {
    more: 0.05,
    down: 0.27,
};
/// Directions by which a part is judged, along each side.
const INSIDE: u32 = 4;

/// The normals that [`receiver_facing`](../passes/shared/receiver.wgsl) numbers; the last stands for all around.
fn facings(steps: u32) -> Vec<Option<DVec3>> {
    let node = |i: u32| 2.0 * f64::from(i) / f64::from(steps) - 1.0;
    let nodes = (0..=steps).flat_map(|y| (0..=steps).map(move |x| (x, y)));
    let mut facings: Vec<_> = nodes
        .map(|(x, y)| Some(octahedral_decode(node(x), node(y))))
        .collect();
    facings.push(None);
    facings
}

fn octahedral_decode(x: f64, y: f64) -> DVec3 {
    let z = 1.0 - x.abs() - y.abs();
    let folded = |a: f64, b: f64| (1.0 - b.abs()) * if a >= 0.0 { 1.0 } else { -1.0 };
    match z < 0.0 {
        true => dvec3(folded(x, y), folded(y, x), z).normalize(),
        false => dvec3(x, y, z).normalize(),
    }
}

/// What is added to the cosine, where that is above so much below zero: for normals that lie between those of a grid.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Between {
    pub(crate) more: f64,
    pub(crate) down: f64,
}

impl Between {
    fn received(self, cosine: f64) -> f64 {
        match cosine > -self.down {
            true => cosine.max(0.0) + self.more,
            false => 0.0,
        }
    }
}

/// Of what each part sends how much a surface receives: the mean of the cosine, with what `between` adds. For each normal that [`facings`]
/// lists, for a sky that is turned by so many whole turns.
pub(crate) fn received(steps: u32, turn: f32, between: Between) -> Vec<[f64; PARTS]> {
    let directions = directions(turn);
    let of_part = |normal: DVec3, part: usize| {
        let inside = &directions[part];
        let weighed = inside
            .iter()
            .map(|&(direction, weight)| weight * between.received(normal.dot(direction)));
        let weights: f64 = inside.iter().map(|&(_, weight)| weight).sum();
        weighed.sum::<f64>() / weights
    };
    facings(steps)
        .into_iter()
        .map(|facing| match facing {
            Some(normal) => std::array::from_fn(|part| of_part(normal, part)),
            None => [1.0; PARTS],
        })
        .collect()
}

/// Directions inside each part, with their solid angles but for a factor: as `sample_in_cell` finds them.
fn directions(turn: f32) -> Vec<Vec<(DVec3, f64)>> {
    let [columns, rows] = SKY_PARTS;
    let side = |at: u32, parts: u32, i: u32| {
        (f64::from(at) + (f64::from(i) + 0.5) / f64::from(INSIDE)) / f64::from(parts)
    };
    let direction = |part: u32, i: u32| {
        let azimuth = TAU * (side(part % columns, columns, i % INSIDE) - f64::from(turn));
        let (sine, cosine) = (PI * side(part / columns, rows, i / INSIDE)).sin_cos();
        let (east, north) = azimuth.sin_cos();
        (dvec3(sine * east, cosine, -sine * north), sine)
    };
    (0..columns * rows)
        .map(|part| (0..INSIDE * INSIDE).map(|i| direction(part, i)).collect())
        .collect()
}

/// Solid angle of each part over that of all together.
pub(crate) fn solid_angles() -> [f64; PARTS] {
    let angles: Vec<f64> = (directions(0.0).iter())
        .map(|inside| inside.iter().map(|&(_, weight)| weight).sum())
        .collect();
    let all: f64 = angles.iter().sum();
    std::array::from_fn(|part| angles[part] / all)
}

/// Appends a row of the tables that `shared/sky_parts.wgsl` reads: for each part the probability that a sample goes there or to a part
/// before. `parts` has the probability of each by what it sends, `weights` how much of that counts; a share of `blind` goes by the
/// former alone. From the last part that sends something on, whatever rounding has left is its own.
pub(crate) fn push_row(rows: &mut Vec<f32>, parts: &[f64], weights: &[f64], blind: f64) {
    let total: f64 = weights.iter().zip(parts).map(|(w, part)| w * part).sum();
    let last = parts.iter().rposition(|&part| part > 0.0).unwrap_or(0);
    let mut sum = 0.0;
    for (i, (weight, part)) in weights.iter().zip(parts).enumerate() {
        let known = weight * part / total.max(f64::MIN_POSITIVE);
        sum += blind * part + (1.0 - blind) * known;
        rows.push(if i >= last { 1.0 } else { sum as f32 });
    }
}

/// Such rows for surfaces of each facing, where nothing is known of the place.
pub(crate) fn facing_rows(parts: &[f64], turn: f32) -> Vec<f32> {
    let mut rows = Vec::new();
    for weights in received(FACING_STEPS, turn, BETWEEN) {
        push_row(&mut rows, parts, &weights, 0.0);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_receives_what_is_above_it() {
        let exact = Between {
            more: 0.0,
            down: 0.0,
        };
        for (facing, received) in facings(4).into_iter().zip(received(4, 0.3, exact)) {
            let all = directions(0.3);
            let weight = |part: usize| all[part].iter().map(|(_, weight)| weight).sum::<f64>();
            let whole: f64 = (0..PARTS).map(weight).sum();
            let mean: f64 = (0..PARTS)
                .map(|part| weight(part) * received[part])
                .sum::<f64>()
                / whole;
            // The mean of a clamped cosine over all directions.
            let expected = if facing.is_some() { 0.25 } else { 1.0 };
            assert!((mean - expected).abs() < 0.01, "{facing:?} {mean}");
        }
    }

    #[test]
    fn up_sees_the_upper_half() {
        let parts = [1.0 / PARTS as f64; PARTS];
        let rows = facing_rows(&parts, 0.0);
        let up = facings(FACING_STEPS)
            .iter()
            .position(|facing| facing.is_some_and(|n| (n - DVec3::Y).length() < 1e-9));
        let row = &rows[up.unwrap_or_default() * PARTS..][..PARTS];
        assert!(row[PARTS / 2 - 1] > 0.95, "{row:?}");
        assert_eq!(row[PARTS - 1], 1.0);
    }

    #[test]
    fn nothing_is_left_out_that_a_normal_between_two_facings_sees() {
        // The corners of the grid's cells are the farthest from its nodes.
        let facings = facings(FACING_STEPS);
        let count = 8 * FACING_STEPS;
        let place = |i: u32| 2.0 * f64::from(i) / f64::from(count) - 1.0;
        for (x, y) in (0..=count).flat_map(|y| (0..=count).map(move |x| (place(x), place(y)))) {
            let node = |v: f64| ((0.5 * v + 0.5) * f64::from(FACING_STEPS)).round() as usize;
            let facing = facings[node(y) * (FACING_STEPS as usize + 1) + node(x)];
            let normal = octahedral_decode(x, y);
            let sine = facing.map_or(1.0, |facing| facing.cross(normal).length());
            assert!(sine < BETWEEN.down, "{x} {y}: {sine}");
        }
    }
}
