//! Which point of the surface each sample of a picture shows: triangles drawn in their texture coordinates.

use std::ops::Range;

use glam::{DVec2, Vec2, Vec3};

/// A sample of the picture that lies in a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    /// Texel of the picture, row by row.
    pub(super) texel: u32,
    pub(super) triangle: u32,
    pub(super) weights: Vec3,
    /// Which sample of its texel, two bits.
    pub(super) corner: u32,
}

/// A triangle in the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drawn {
    pub(super) triangle: u32,
    pub(super) uv: [Vec2; 3],
}

/// Samples of some rows of texels.
#[derive(Debug, Default)]
pub(super) struct Covered {
    pub(super) samples: Vec<Sample>,
    /// So many would show a second triangle as well.
    pub(super) twice: u64,
}

/// Draws triangles into some rows of texels of a square picture with `side` texels, each with `grid` x `grid` samples. What
/// lies outside [0, 1] comes back on the other side. Where triangles overlap, the first one is shown.
pub(super) fn cover(drawn: &[Drawn], side: u32, grid: u32, rows: Range<u32>) -> Covered {
    let cells = i64::from(side * grid);
    let (first, last) = (i64::from(rows.start * grid), i64::from(rows.end * grid));
    let mut owners: Vec<Option<(u32, Vec3)>> = vec![None; (cells * (last - first)) as usize];
    let mut twice = 0;
    for Drawn { triangle, uv } in drawn {
        let corners = uv.map(|p| p.as_dvec2() * cells as f64);
        let area = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]);
        if area == 0.0 || !area.is_finite() {
            continue;
        }
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        let (x0, x1) = span(low.x, high.x);
        let (y0, y1) = span(low.y, high.y);
        if (x1 - x0 > cells || y1 - y0 > cells) && rows.start == 0 {
            // What repeats the picture has no place of its own but once.
            twice += (0.5 * area.abs() - (cells * cells) as f64).clamp(1.0, 1e15) as u64;
        }
        // More than the whole picture shows nothing new.
        let (x1, y1) = (x1.min(x0 + cells), y1.min(y0 + cells));
        for tile in y0.div_euclid(cells)..=(y1 - 1).div_euclid(cells) {
            let top = (tile * cells + first).max(y0);
            let bottom = (tile * cells + last).min(y1);
            for y in top..bottom {
                let row = (y - tile * cells - first) * cells;
                for x in x0..x1 {
                    let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                    let Some(weights) = weights(corners, area, at) else {
                        continue;
                    };
                    let owner = &mut owners[(row + x.rem_euclid(cells)) as usize];
                    match owner {
                        None => *owner = Some((*triangle, weights)),
                        // On an edge that two triangles share, both are there.
                        Some(_) if weights.min_element() > 1e-3 => twice += 1,
                        Some(_) => {}
                    }
                }
            }
        }
    }
    Covered {
        samples: samples(&owners, side, grid, rows.start),
        twice,
    }
}

/// Whole cells from one place up to another.
fn span(low: f64, high: f64) -> (i64, i64) {
    // Coordinates beyond this have no fraction left anyway.
    let whole = |x: f64| x.clamp(-1e12, 1e12) as i64;
    (
        whole(low.floor()),
        whole(high.ceil()).max(whole(low.floor()) + 1),
    )
}

fn weights([a, b, c]: [DVec2; 3], area: f64, at: DVec2) -> Option<Vec3> {
    let second = (at - a).perp_dot(c - a) / area;
    let third = (b - a).perp_dot(at - a) / area;
    let first = 1.0 - second - third;
    let is_inside = first.min(second).min(third) >= -1e-9;
    is_inside.then(|| Vec3::new(first as f32, second as f32, third as f32))
}

fn samples(owners: &[Option<(u32, Vec3)>], side: u32, grid: u32, first_row: u32) -> Vec<Sample> {
    let cells = side * grid;
    let sample = |(cell, owner): (usize, &Option<(u32, Vec3)>)| {
        let (triangle, weights) = (*owner)?;
        let (x, y) = (cell as u32 % cells, cell as u32 / cells);
        Some(Sample {
            texel: (first_row + y / grid) * side + x / grid,
            triangle,
            weights,
            corner: (x & 1) | ((y & 1) << 1),
        })
    };
    owners.iter().enumerate().filter_map(sample).collect()
}

/// For each texel that shows nothing, the nearest one that does, by steps to the side, up and down: what filters read across
/// the borders of what is shown. Nothing where no texel shows anything.
pub(super) fn nearest(is_shown: &[bool], side: u32) -> Vec<(u32, u32)> {
    let mut source: Vec<u32> = (0u32..)
        .zip(is_shown)
        .map(|(texel, &shown)| if shown { texel } else { u32::MAX })
        .collect();
    let mut ring: Vec<u32> = (0u32..)
        .zip(is_shown)
        .filter_map(|(texel, &shown)| shown.then_some(texel))
        .collect();
    let mut pairs = Vec::new();
    while !ring.is_empty() {
        let mut next = Vec::new();
        for texel in ring {
            let (x, y) = (texel % side, texel / side);
            let neighbours = [
                (x > 0).then(|| texel - 1),
                (x + 1 < side).then(|| texel + 1),
                (y > 0).then(|| texel - side),
                (y + 1 < side).then(|| texel + side),
            ];
            for neighbour in neighbours.into_iter().flatten() {
                if source[neighbour as usize] == u32::MAX {
                    source[neighbour as usize] = source[texel as usize];
                    pairs.push((neighbour, source[texel as usize]));
                    next.push(neighbour);
                }
            }
        }
        ring = next;
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: Vec2, high: Vec2) -> Vec<Drawn> {
        let [a, b, c, d] = [
            low,
            Vec2::new(low.x, high.y),
            high,
            Vec2::new(high.x, low.y),
        ];
        let drawn = |triangle, uv| Drawn { triangle, uv };
        vec![drawn(0, [a, b, c]), drawn(1, [a, c, d])]
    }

    #[test]
    fn a_square_is_covered_once() {
        let covered = cover(&square(Vec2::ZERO, Vec2::ONE), 8, 2, 0..8);
        assert_eq!((covered.samples.len(), covered.twice), (256, 0));
        let band = cover(&square(Vec2::ZERO, Vec2::ONE), 8, 2, 3..5);
        assert_eq!(band.samples.len(), 64);
        assert!(band.samples.iter().all(|s| (24..40).contains(&s.texel)));
    }

    #[test]
    fn weights_lead_back_to_the_place() {
        let drawn = square(Vec2::new(0.1, 0.2), Vec2::new(0.9, 0.7));
        for sample in cover(&drawn, 16, 1, 0..16).samples {
            let uv = drawn[sample.triangle as usize].uv;
            let at: Vec2 = (0..3).map(|i| uv[i] * sample.weights[i]).sum();
            let texel = Vec2::new((sample.texel % 16) as f32, (sample.texel / 16) as f32);
            assert!((at * 16.0 - texel - 0.5).length() < 1e-4);
        }
    }

    #[test]
    fn what_lies_outside_comes_back_and_overlaps_are_counted() {
        let covered = cover(&square(Vec2::splat(-0.5), Vec2::splat(0.5)), 8, 1, 0..8);
        assert_eq!((covered.samples.len(), covered.twice), (64, 0));
        let covered = cover(&square(Vec2::ZERO, Vec2::splat(2.0)), 8, 1, 0..8);
        assert!(covered.twice > 0);
        let far = cover(&square(Vec2::splat(-1e30), Vec2::splat(1e30)), 8, 1, 0..8);
        assert!(far.samples.len() <= 64);
    }

    #[test]
    fn all_texels_get_the_nearest_one_that_shows_something() {
        let mut is_shown = vec![false; 25];
        is_shown[0] = true;
        is_shown[24] = true;
        let pairs = nearest(&is_shown, 5);
        assert_eq!(pairs.len(), 23);
        assert!(pairs.contains(&(1, 0)) && pairs.contains(&(23, 24)));
        assert!(nearest(&[false; 4], 2).is_empty());
    }
}
