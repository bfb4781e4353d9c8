//! Openings: rectangles on the sides of the box around the scene, by which the sky is seen from inside.
//!
//! The windows of a room lie in the same places of the box wherever one looks from, so that they are found by all paths together, far finer than
//! what each of many places sees of each of many parts of the sky. Light samples that are uniform over a rectangle meet a window's frame
//! only where the rectangle covers it, and what they bring differs by its distance alone (as through the portals of Bitterli, Novák and
//! Jarosz, "Portal-Masked Environment Map Sampling", 2015, which are placed by hand).

use std::ops::Range;

use glam::Vec3;

/// Openings, at most, and squares along each side of a side of the box: as in `shared/openings.wgsl`.
pub(super) const OPENINGS: usize = 64;
const SQUARES: usize = 128;
/// Squares of all sides.
pub(super) const ALL_SQUARES: usize = 6 * SQUARES * SQUARES;
/// Columns of the image that say which opening each square belongs to, two squares in a number, and then where openings are.
pub(super) const COLUMNS: usize = SQUARES / 8;
/// Share of the box that openings may cover: where it is more, the sky is all around, and told apart by directions better.
const MOST_OPEN: f64 = 0.4;
/// Of all that arrives so much may be left to no opening, where it comes so much more sparsely than through the rest: by a gap between
/// two walls, over half a side of the box.
const RARE: f64 = 0.02;
const SPARSE: f64 = 0.1;

/// A rectangle on a side of the box.
#[derive(Debug, Clone, PartialEq)]
struct Opening {
    /// Twice the axis, and one where that grows.
    side: usize,
    columns: Range<usize>,
    rows: Range<usize>,
    arrived: u64,
}

impl Opening {
    fn squares(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    /// About the square of the noise of samples that are uniform over it, of which it gets as many as have arrived.
    fn noise(&self, areas: &[f64; 6]) -> f64 {
        self.arrived as f64 * self.area(areas)
    }

    fn area(&self, areas: &[f64; 6]) -> f64 {
        self.squares() as f64 * areas[self.side]
    }

    /// How densely samples arrive by way of it.
    fn density(&self, areas: &[f64; 6]) -> f64 {
        self.arrived as f64 / self.area(areas)
    }
}

/// Sums of all squares before one, along both axes.
struct Sums(Vec<u64>);

impl Sums {
    fn of(side: &[u32]) -> Self {
        let width = SQUARES + 1;
        let mut sums = vec![0; width * width];
        for (i, &count) in side.iter().enumerate() {
            let at = (i / SQUARES + 1) * width + i % SQUARES + 1;
            sums[at] = u64::from(count) + sums[at - 1] + sums[at - width] - sums[at - width - 1];
        }
        Self(sums)
    }

    fn within(&self, columns: &Range<usize>, rows: &Range<usize>) -> u64 {
        let at = |row: usize, column: usize| self.0[row * (SQUARES + 1) + column];
        at(rows.end, columns.end) + at(rows.start, columns.start)
            - at(rows.start, columns.end)
            - at(rows.end, columns.start)
    }

    /// The least rectangle that has all that is within one; none where nothing is.
    fn tight(
        &self,
        side: usize,
        mut columns: Range<usize>,
        mut rows: Range<usize>,
    ) -> Option<Opening> {
        let arrived = self.within(&columns, &rows);
        if arrived == 0 {
            return None;
        }
        while self.within(&(columns.start..columns.start + 1), &rows) == 0 {
            columns.start += 1;
        }
        while self.within(&(columns.end - 1..columns.end), &rows) == 0 {
            columns.end -= 1;
        }
        while self.within(&columns, &(rows.start..rows.start + 1)) == 0 {
            rows.start += 1;
        }
        while self.within(&columns, &(rows.end - 1..rows.end)) == 0 {
            rows.end -= 1;
        }
        Some(Opening {
            side,
            columns,
            rows,
            arrived,
        })
    }

    /// The two into which one is cut best, and by how much that lowers its noise.
    fn cut(&self, opening: &Opening, areas: &[f64; 6]) -> Option<(f64, [Opening; 2])> {
        let (side, columns, rows) = (opening.side, &opening.columns, &opening.rows);
        let upright = (columns.start + 1..columns.end).map(|at| {
            (
                (columns.start..at, rows.clone()),
                (at..columns.end, rows.clone()),
            )
        });
        let level = (rows.start + 1..rows.end).map(|at| {
            (
                (columns.clone(), rows.start..at),
                (columns.clone(), at..rows.end),
            )
        });
        upright
            .chain(level)
            .filter_map(|(a, b)| {
                let parts = [self.tight(side, a.0, a.1)?, self.tight(side, b.0, b.1)?];
                let noise: f64 = parts.iter().map(|part| part.noise(areas)).sum();
                Some((opening.noise(areas) - noise, parts))
            })
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// Cuts openings until there are as many as there may be.
fn cut_up(all: Vec<Opening>, sums: &[Sums], areas: &[f64; 6]) -> Vec<Opening> {
    let with_cut = |one: Opening| (sums[one.side].cut(&one, areas), one);
    let mut found: Vec<_> = all.into_iter().map(with_cut).collect();
    while found.len() < OPENINGS {
        let best = (found.iter().enumerate())
            .filter_map(|(i, (cut, _))| cut.as_ref().map(|cut| (i, cut.0)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((i, _)) = best else {
            break;
        };
        if let (Some((_, parts)), _) = found.swap_remove(i) {
            found.extend(parts.map(with_cut));
        }
    }
    found.into_iter().map(|(_, opening)| opening).collect()
}

/// Leaves those out by which samples arrive most sparsely, as long as it is far more sparsely than by the rest; no more than so many
/// samples in all. How many that are.
fn leave_sparse(all: &mut Vec<Opening>, areas: &[f64; 6], most: f64) -> u64 {
    // The sparsest come last.
    all.sort_by(|a, b| b.density(areas).total_cmp(&a.density(areas)));
    let mut arrived: u64 = all.iter().map(|one| one.arrived).sum();
    let mut area: f64 = all.iter().map(|one| one.area(areas)).sum();
    let mut left = 0;
    while let Some(last) = all.last() {
        arrived -= last.arrived;
        area -= last.area(areas);
        let is_sparse = last.density(areas) * area < SPARSE * arrived as f64;
        if !is_sparse || (left + last.arrived) as f64 > most {
            break;
        }
        left += last.arrived;
        all.pop();
    }
    left
}

/// What is known of the openings.
#[derive(Debug, Default)]
pub(super) struct Openings {
    all: Vec<Opening>,
    areas: [f64; 6],
}

impl Openings {
    /// Finds them by how many samples have arrived by way of each square of a box; none where the sky is all around.
    pub(super) fn find(arrived: &[u32], [low, high]: [Vec3; 2]) -> Self {
        let size = (high - low).as_dvec3();
        let squares = (SQUARES * SQUARES) as f64;
        // Of a square.
        let areas = std::array::from_fn(|side| {
            let axis = side / 2;
            size[(axis + 1) % 3] * size[(axis + 2) % 3] / squares
        });
        let sums: Vec<Sums> = arrived
            .chunks_exact(SQUARES * SQUARES)
            .map(Sums::of)
            .collect();
        let mut all: Vec<_> = (sums.iter().enumerate())
            .filter(|&(side, _)| areas[side] > 0.0)
            .filter_map(|(side, sums)| sums.tight(side, 0..SQUARES, 0..SQUARES))
            .collect();
        let mut may_leave = RARE * all.iter().map(|one| one.arrived as f64).sum::<f64>();
        loop {
            all = cut_up(all, &sums, &areas);
            // What is rare would make a room look as open as a field, and take openings from where light comes from.
            let left = leave_sparse(&mut all, &areas, may_leave);
            if left == 0 {
                break;
            }
            may_leave -= left as f64;
        }
        let open: f64 = all.iter().map(|one| one.area(&areas)).sum();
        match open > MOST_OPEN * areas.iter().sum::<f64>() * squares {
            true => Self::default(),
            false => Self { all, areas },
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Of what arrives how much comes through each: first through none, then as they are numbered.
    pub(super) fn shares(&self) -> [f64; OPENINGS + 1] {
        let total: u64 = self.all.iter().map(|one| one.arrived).sum();
        std::array::from_fn(|i| match i.checked_sub(1).and_then(|i| self.all.get(i)) {
            Some(one) => one.arrived as f64 / total as f64,
            None => 0.0,
        })
    }

    /// Puts them into the last columns of an image, whose rows have so many numbers.
    pub(super) fn put_into(&self, image: &mut [f32], row_length: usize) {
        let mut numbers = vec![0_u8; ALL_SQUARES];
        let texel = |column: usize, row: usize| (row + 1) * row_length - 4 * (COLUMNS - column);
        for (i, opening) in self.all.iter().enumerate() {
            for row in opening.rows.clone() {
                let first = (opening.side * SQUARES + row) * SQUARES;
                numbers[first..][opening.columns.clone()].fill(i as u8 + 1);
            }
            let corner = |column: usize, row: usize| (column + 256 * row) as f32;
            let record = [
                corner(opening.columns.start, opening.rows.start),
                corner(opening.columns.end, opening.rows.end),
                opening.side as f32,
                (1.0 / (opening.squares() as f64 * self.areas[opening.side])) as f32,
            ];
            let at = texel(i % COLUMNS, ALL_SQUARES / SQUARES + i / COLUMNS);
            image[at..at + 4].copy_from_slice(&record);
        }
        for (row, numbers) in numbers.chunks_exact(SQUARES).enumerate() {
            let twos = numbers.chunks_exact(2);
            let twos = twos.map(|two| f32::from(u16::from_le_bytes([two[0], two[1]])));
            let columns = &mut image[texel(0, row)..][..4 * COLUMNS];
            columns.iter_mut().zip(twos).for_each(|(to, two)| *to = two);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of a side that have so many each.
    fn with(windows: &[(usize, Range<usize>, Range<usize>)]) -> Vec<u32> {
        let mut arrived = vec![0; ALL_SQUARES];
        for (side, columns, rows) in windows {
            for row in rows.clone() {
                for column in columns.clone() {
                    arrived[(side * SQUARES + row) * SQUARES + column] = 10;
                }
            }
        }
        arrived
    }

    #[test]
    fn windows_become_openings_and_frames_do_not() {
        // Two panes with a frame between, and a skylight.
        let windows = [(1, 20..40, 30..60), (1, 43..63, 30..60), (3, 5..15, 5..9)];
        let arrived = with(&windows);
        let openings = Openings::find(&arrived, [Vec3::ZERO, Vec3::new(6.0, 3.0, 4.0)]);
        assert_eq!(openings.all.len(), OPENINGS);
        let squares: usize = openings.all.iter().map(Opening::squares).sum();
        assert_eq!(squares, 2 * 20 * 30 + 10 * 4);
        let row_length = 4 * (COLUMNS + 3);
        let rows = 6 * SQUARES + OPENINGS.div_ceil(COLUMNS);
        let mut image = vec![0.0; rows * row_length];
        openings.put_into(&mut image, row_length);
        let number = |side: usize, column: usize, row: usize| {
            let two = image[(side * SQUARES + row) * row_length + 12 + column / 2];
            (two as usize) >> (8 * (column % 2)) & 0xff
        };
        assert_eq!(number(1, 41, 40), 0);
        for (side, columns, rows) in windows {
            for (column, row) in columns.zip(rows) {
                let found = &openings.all[number(side, column, row) - 1];
                assert_eq!(found.side, side);
                assert!(found.columns.contains(&column) && found.rows.contains(&row));
            }
        }
        let area: f32 = (0..OPENINGS)
            .map(|i| {
                let row = (6 * SQUARES + i / COLUMNS) * row_length;
                1.0 / image[row + 12 + 4 * (i % COLUMNS) + 3]
            })
            .sum();
        let wanted = 1200.0 * 12.0 / 16384.0 + 40.0 * 24.0 / 16384.0;
        assert!((area - wanted).abs() < 1e-4, "{area} {wanted}");
        let shares: f64 = openings.shares().iter().sum();
        assert!((shares - 1.0).abs() < 1e-9);
    }

    #[test]
    fn gaps_do_not_make_a_room_an_open_place() {
        let windows = [(1, 20..40, 30..60), (1, 43..63, 30..60)];
        let mut arrived = with(&windows);
        // A few samples get out all over the ceiling and another wall.
        for square in 0..2 * SQUARES * SQUARES {
            if square % 331 == 0 {
                arrived[2 * SQUARES * SQUARES + square] = 1;
            }
        }
        let openings = Openings::find(&arrived, [Vec3::ZERO, Vec3::ONE]);
        assert_eq!(openings.all.len(), OPENINGS);
        assert!(openings.all.iter().all(|one| one.side == 1));
        let squares: usize = openings.all.iter().map(Opening::squares).sum();
        assert_eq!(squares, 2 * 20 * 30);
    }

    #[test]
    fn an_open_place_has_none() {
        let sides: Vec<_> = (0..5).map(|side| (side, 0..SQUARES, 0..SQUARES)).collect();
        let openings = Openings::find(&with(&sides), [Vec3::ZERO, Vec3::ONE]);
        assert!(openings.is_empty());
        assert!(Openings::find(&with(&[]), [Vec3::ZERO, Vec3::ONE]).is_empty());
        // A flat scene.
        assert!(Openings::find(&with(&sides), [Vec3::ZERO, Vec3::X]).is_empty());
    }
}
