//! Which point of the surface each sample of a picture shows: triangles drawn in their texture coordinates.

use std::ops::Range;

use glam::{DVec2, Vec2, Vec3};

use crate::scene::Mesh;

/// Coordinates beyond so many cells have no fraction left anyway.
const FAR: f64 = 1e12;
/// Of a triangle that repeats the picture downwards, so many repetitions are looked at about.
const MOST_TILES: i64 = 32;
/// A triangle is crushed that has less than this share of the picture that its surface would have by the mean of all: a quarter of
/// the texels along a side. Small triangles of a fine mesh aren't, whose neighbours' texels show what they are like.
const CRUSHED: f64 = 1.0 / 16.0;

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
    let rows_of_cells = i64::from(rows.start * grid)..i64::from(rows.end * grid);
    let mut canvas = Canvas::new(cells, rows_of_cells);
    for &Drawn { triangle, uv } in drawn {
        let corners = uv.map(|p| p.as_dvec2() * cells as f64);
        let area = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]);
        if area == 0.0 || !area.is_finite() {
            continue;
        }
        let shape = Shape {
            triangle,
            corners,
            area,
        };
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        let (columns, lines) = (span(low.x, high.x), span(low.y, high.y));
        match columns.end - columns.start > cells || lines.end - lines.start > cells {
            true => canvas.repeat(&shape, &lines),
            false => canvas.draw(&shape, &columns, &lines),
        }
    }
    Covered {
        samples: samples(&canvas.owners, side, grid, rows.start),
        twice: canvas.twice,
    }
}

/// The share of a surface, that of the `drawn` triangles of a mesh, that is crushed on the picture and `is_lost`, which is told twice
/// the triangle's area there, in that of the picture. It shows what is elsewhere, as the sides of a box do whose picture lies on it
/// from above.
pub(super) fn crushed(mesh: &Mesh, drawn: &[Drawn], is_lost: impl Fn(&Drawn, f64) -> bool) -> f64 {
    let known = |x: f64| if x.is_finite() { x } else { 0.0 };
    let areas: Vec<[f64; 2]> = (drawn.iter())
        .map(|drawn| {
            let [a, b, c] = drawn.uv.map(|p| p.as_dvec2());
            let corners = mesh.triangles[drawn.triangle as usize];
            let [p, q, r] = corners.map(|i| mesh.positions[i as usize].as_dvec3());
            [
                known((b - a).perp_dot(c - a).abs()),
                known((q - p).cross(r - p).length()),
            ]
        })
        .collect();
    let [picture, surface] = [0, 1].map(|i| areas.iter().map(|areas| areas[i]).sum::<f64>());
    let lost = (drawn.iter().zip(&areas)).filter(|(drawn, [on_picture, on_surface])| {
        on_picture * surface < CRUSHED * picture * on_surface && is_lost(drawn, *on_picture)
    });
    lost.map(|(_, [_, on_surface])| on_surface).sum::<f64>() / surface.max(f64::MIN_POSITIVE)
}

/// Some rows of a picture's cells, a sample each, while triangles are drawn into them. Outside of the picture are copies of it,
/// the tiles, whose cells go on counting.
struct Canvas {
    /// Along a side of the picture.
    cells: i64,
    rows: Range<i64>,
    owners: Vec<Option<(u32, Vec3)>>,
    /// How many cells of each row nobody has yet.
    free: Vec<i64>,
    twice: u64,
}

impl Canvas {
    fn new(cells: i64, rows: Range<i64>) -> Self {
        let count = (rows.end - rows.start) as usize;
        Self {
            cells,
            rows,
            owners: vec![None; count * cells as usize],
            free: vec![cells; count],
            twice: 0,
        }
    }

    /// A triangle that is no larger than the picture.
    fn draw(&mut self, shape: &Shape, columns: &Range<i64>, lines: &Range<i64>) {
        for tile in tiles(lines, self.cells) {
            let start = tile * self.cells;
            let top = (start + self.rows.start).max(lines.start);
            let bottom = (start + self.rows.end).min(lines.end);
            for y in top..bottom {
                for x in columns.clone() {
                    self.mark(shape, y - start, x, y);
                }
            }
        }
    }

    /// A triangle that may have several places for a cell. The tile in its middle is shown as far as it goes, then those around
    /// it: what lies side by side on the triangle does so on the picture.
    fn repeat(&mut self, shape: &Shape, lines: &Range<i64>) {
        let cells = self.cells;
        let [column, middle] = shape.middle().map(|x| whole(x.floor()).div_euclid(cells));
        let all = tiles(lines, cells);
        let tried = some_of(&all, middle);
        let before = self.twice;
        for tile in &tried {
            for row in self.rows.clone() {
                self.repeat_line(shape, row, tile * cells + row, column);
            }
        }
        // What wasn't tried repeats the picture as what was.
        let more = (all.end - all.start) as f64 / tried.len() as f64 - 1.0;
        let beyond = (self.twice - before) as f64 * more;
        self.twice = self.twice.saturating_add(beyond as u64);
    }

    /// A line of such a triangle, which goes into a row of the picture; `column` is the tile in the middle.
    fn repeat_line(&mut self, shape: &Shape, row: i64, y: i64, column: i64) {
        let cells = self.cells;
        let line = shape.line(y);
        let mut again = (line.end - line.start).max(0);
        if again > 0 && self.free[(row - self.rows.start) as usize] > 0 {
            let columns = tiles(&line, cells);
            let near = column.clamp(columns.start, columns.end - 1);
            // Where the line goes on beyond these, it has filled the row.
            for tile in [near, near - 1, near + 1] {
                let part = line.start.max(tile * cells)..line.end.min((tile + 1) * cells);
                again -= (part.end - part.start).max(0);
                for x in part {
                    self.mark(shape, row, x, y);
                }
            }
        }
        self.twice = self.twice.saturating_add(again as u64);
    }

    /// Gives a cell to the triangle if its middle lies within and nobody has it; `row` is where `y` is in the picture.
    fn mark(&mut self, shape: &Shape, row: i64, x: i64, y: i64) {
        let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let Some(weights) = shape.weights(at) else {
            return;
        };
        let row = row - self.rows.start;
        let owner = &mut self.owners[(row * self.cells + x.rem_euclid(self.cells)) as usize];
        match owner {
            None => {
                *owner = Some((shape.triangle, weights));
                self.free[row as usize] -= 1;
            }
            // On an edge that two triangles share, both are there.
            Some(_) if weights.min_element() > 1e-3 => self.twice = self.twice.saturating_add(1),
            Some(_) => {}
        }
    }
}

/// A triangle in cells.
struct Shape {
    triangle: u32,
    corners: [DVec2; 3],
    /// Twice its area; less than 0 where it is mirrored.
    area: f64,
}

impl Shape {
    fn middle(&self) -> [f64; 2] {
        let [a, b, c] = self.corners;
        ((a + b + c) / 3.0).to_array()
    }

    /// The cells of a line whose middles lie within.
    fn line(&self, y: i64) -> Range<i64> {
        let at = y as f64 + 0.5;
        let [a, b, c] = self.corners;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if (from.y <= at) != (to.y <= at) {
                let x = from.x + (to.x - from.x) * ((at - from.y) / (to.y - from.y));
                (low, high) = (low.min(x), high.max(x));
            }
        }
        // Those on the edge, too, however it is rounded: the weights decide.
        let (low, high) = (low - 0.5 - 1e-6, high - 0.5 + 1e-6);
        whole(low.ceil())..whole(high.floor()) + 1
    }

    fn weights(&self, at: DVec2) -> Option<Vec3> {
        let [a, b, c] = self.corners;
        let second = (at - a).perp_dot(c - a) / self.area;
        let third = (b - a).perp_dot(at - a) / self.area;
        let first = 1.0 - second - third;
        let is_inside = first.min(second).min(third) >= -1e-9;
        is_inside.then(|| Vec3::new(first as f32, second as f32, third as f32))
    }
}

fn whole(x: f64) -> i64 {
    x.clamp(-FAR, FAR) as i64
}

/// Whole cells from one place up to another.
fn span(low: f64, high: f64) -> Range<i64> {
    let start = whole(low.floor());
    start..whole(high.ceil()).max(start + 1)
}

/// The tiles that some cells lie in; there is a cell at least.
fn tiles(range: &Range<i64>, cells: i64) -> Range<i64> {
    range.start.div_euclid(cells)..(range.end - 1).div_euclid(cells) + 1
}

/// All of some tiles, or a few from one end to the other where they are many; those near the middle come first.
fn some_of(tiles: &Range<i64>, middle: i64) -> Vec<i64> {
    let count = tiles.end - tiles.start;
    let taken = count.min(MOST_TILES);
    let mut some: Vec<i64> = (0..taken)
        .map(|i| tiles.start + (count - 1) * i / (taken - 1).max(1))
        .collect();
    let middle = middle.clamp(tiles.start, tiles.end - 1);
    if !some.contains(&middle) {
        some.push(middle);
    }
    some.sort_by_key(|tile| (tile - middle).abs());
    some
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
    fn what_is_crushed_is_told_from_what_is_fine() {
        // Squares of a metre in a row, whose pictures are less and less wide.
        let mesh = |count: u32| Mesh {
            positions: (0..=count)
                .flat_map(|x| [0.0, 1.0].map(|y| Vec3::new(x as f32, y, 0.0)))
                .collect(),
            triangles: (0..count)
                .flat_map(|x| {
                    [
                        [2 * x, 2 * x + 2, 2 * x + 1],
                        [2 * x + 1, 2 * x + 2, 2 * x + 3],
                    ]
                })
                .collect(),
            ..Mesh::default()
        };
        let shares = |widths: &[f32]| {
            let mesh = mesh(widths.len() as u32);
            let mut ends = vec![0.0];
            for width in widths {
                ends.push(ends[ends.len() - 1] + width);
            }
            let uv = |i: u32| Vec2::new(ends[i as usize / 2], (i % 2) as f32);
            let drawn: Vec<Drawn> = (0u32..)
                .zip(&mesh.triangles)
                .map(|(triangle, corners)| Drawn {
                    triangle,
                    uv: corners.map(uv),
                })
                .collect();
            crushed(&mesh, &drawn, |_, area| area < 0.1)
        };
        assert_eq!(shares(&[0.5, 0.5, 0.0, 0.0]), 0.5);
        assert_eq!(shares(&[0.5, 0.5, 0.0, 0.002]), 0.5);
        assert_eq!(shares(&[0.5, 0.5, 0.3, 0.2]), 0.0);
        // However small, they are as large as the others.
        assert_eq!(shares(&[0.01; 100]), 0.0);
        assert_eq!(shares(&[f32::NAN, 0.5]), 0.0);
        assert_eq!(crushed(&Mesh::default(), &[], |_, _| true), 0.0);
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
    fn a_triangle_that_repeats_the_picture_is_shown_wherever_it_has_a_texel() {
        let uv = [[0.0, 1.5], [1.5, 1.5], [1.5, 0.0]].map(Vec2::from);
        let drawn = [Drawn { triangle: 0, uv }];
        let covered = cover(&drawn, 64, 1, 0..64);
        // No tile has those of which both coordinates are above 0.5, and their sum below 1.5.
        assert_eq!(covered.samples.len(), 3600);
        for sample in &covered.samples {
            let at: Vec2 = (0..3).map(|i| uv[i] * sample.weights[i]).sum();
            let texel = Vec2::new((sample.texel % 64) as f32, (sample.texel / 64) as f32);
            let off = (at - at.floor()) * 64.0 - texel - 0.5;
            assert!(off.length() < 1e-2, "{sample:?}: {at}");
        }
        // It has 4656 texels in all, some of them on its edge, which others may share.
        assert!((960..=1056).contains(&covered.twice), "{}", covered.twice);
        let bands = [0..20, 20..64].map(|rows| cover(&drawn, 64, 1, rows));
        let samples: usize = bands.iter().map(|band| band.samples.len()).sum();
        let twice: u64 = bands.iter().map(|band| band.twice).sum();
        assert_eq!((samples, twice), (3600, covered.twice));
    }

    #[test]
    fn what_is_wider_than_the_picture_may_still_have_room_on_it() {
        // One and a half times the picture: a third of it is shown elsewhere.
        let wide = square(Vec2::new(0.0, 0.0), Vec2::new(1.5, 0.25));
        let covered = cover(&wide, 32, 1, 0..32);
        let own = covered.samples.len() as u64;
        assert_eq!(own, 32 * 8);
        assert!((own / 2).abs_diff(covered.twice) <= 16, "{}", covered.twice);
        // One that leans goes past itself.
        let corners = [[0.0, 0.0], [1.9, 0.9], [1.9, 0.95]].map(Vec2::from);
        let lean = [Drawn {
            triangle: 0,
            uv: corners,
        }];
        let covered = cover(&lean, 64, 1, 0..64);
        assert!(covered.samples.len() > 80, "{}", covered.samples.len());
        assert_eq!(covered.twice, 0);
    }

    #[test]
    fn triangles_over_millions_of_tiles_take_no_longer() {
        for (corners, least) in [
            ([[0.0, 0.0], [1e6, 3e5], [2e5, 1e6]], 1024),
            ([[-1e6, -1e6], [1e6, -1e6], [0.0, 1e6]], 1024),
            ([[0.0, 0.0], [0.75, 0.0], [0.0, 1e6]], 700),
            ([[0.0, 0.0], [1e6, 0.0], [0.0, 0.75]], 700),
            ([[0.0, 0.0], [1e6, 1e6], [1e6, 1e6 + 0.25]], 1),
        ] {
            let uv = corners.map(Vec2::from);
            let covered = cover(&[Drawn { triangle: 0, uv }], 32, 1, 0..32);
            let shown = covered.samples.len();
            assert!(shown >= least, "{corners:?}: {shown}");
        }
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
