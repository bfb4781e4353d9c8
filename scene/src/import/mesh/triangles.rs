//! Index lists to lists of usable triangles.

use super::error::Fault;
use super::geometry::Dropped;
use glam::Vec3;
use gltf::json::mesh::Mode;
use std::collections::HashMap;

/// The vertices of a primitive in drawing order.
pub(super) enum Indices {
    List(Vec<u32>),
    /// 0, 1, 2, ...
    Sequence(u32),
}

impl Indices {
    fn len(&self) -> u64 {
        match self {
            Self::List(list) => list.len() as u64,
            Self::Sequence(count) => u64::from(*count),
        }
    }

    fn at(&self, position: u32) -> u32 {
        match self {
            Self::List(list) => list[position as usize],
            Self::Sequence(_) => position,
        }
    }

    pub(super) fn triangle_count(&self, mode: Mode) -> u64 {
        match mode {
            Mode::TriangleStrip | Mode::TriangleFan => self.len().saturating_sub(2),
            _ => self.len() / 3,
        }
    }

    /// Whether indices at the end make no triangle.
    pub(super) fn left_over(&self, mode: Mode) -> bool {
        match mode {
            Mode::TriangleStrip | Mode::TriangleFan => (1..3).contains(&self.len()),
            _ => !self.len().is_multiple_of(3),
        }
    }

    /// The triangles with glTF's winding (section 3.7.2.1). An index that is not below `vertex_count` is an error.
    pub(super) fn triangles(&self, mode: Mode, vertex_count: u32) -> Result<Vec<[u32; 3]>, Fault> {
        if let Self::List(list) = self
            && let Some(position) = list.iter().position(|&index| index >= vertex_count)
        {
            return Err(format!(
                "index {} at position {position} is out of range, there are {vertex_count} vertices",
                list[position]
            ));
        }
        let count =
            u32::try_from(self.triangle_count(mode)).map_err(|_| "has too many triangles")?;
        let positions = |i: u32| match mode {
            Mode::TriangleStrip if i % 2 == 1 => [i, i + 2, i + 1],
            Mode::TriangleStrip => [i, i + 1, i + 2],
            Mode::TriangleFan => [i + 1, i + 2, 0],
            _ => [i * 3, i * 3 + 1, i * 3 + 2],
        };
        Ok((0..count)
            .map(|i| positions(i).map(|p| self.at(p)))
            .collect())
    }
}

/// Renumbers vertices in order of first use and returns the old number of each.
pub(super) fn compact(triangles: &mut [[u32; 3]], vertex_count: u32) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let corners = triangles.len() as u64 * 3;
    let mut used = Vec::new();
    // A table costs time and memory for all vertices, which a primitive that uses few of them should not pay.
    if u64::from(vertex_count) > 4 * corners + 1024 {
        let mut renamed = HashMap::new();
        for vertex in triangles.iter_mut().flatten() {
            *vertex = *renamed.entry(*vertex).or_insert_with(|| {
                used.push(*vertex);
                used.len() as u32 - 1
            });
        }
    } else {
        let mut renamed = vec![NONE; vertex_count as usize];
        for vertex in triangles.iter_mut().flatten() {
            let new = &mut renamed[*vertex as usize];
            if *new == NONE {
                *new = used.len() as u32;
                used.push(*vertex);
            }
            *vertex = *new;
        }
    }
    used
}

/// Removes triangles that have no area or a vertex that is not finite. Returns whether all were kept.
pub(super) fn keep_usable(
    triangles: &mut Vec<[u32; 3]>,
    positions: &[Vec3],
    dropped: &mut Dropped,
) -> bool {
    let before = triangles.len();
    triangles.retain(|&triangle| {
        let [a, b, c] = triangle;
        if !triangle.iter().all(|&v| positions[v as usize].is_finite()) {
            dropped.non_finite += 1;
            return false;
        }
        // Evaluated in the precision that the renderer has: an area that vanishes there has no normal.
        let cross = cross(triangle, positions);
        let usable = a != b && b != c && c != a && cross != Vec3::ZERO && cross.is_finite();
        dropped.degenerate += u64::from(!usable);
        usable
    });
    triangles.len() == before
}

/// Normal of a triangle, twice its area long.
pub(super) fn cross([a, b, c]: [u32; 3], positions: &[Vec3]) -> Vec3 {
    let [a, b, c] = [a, b, c].map(|v| positions[v as usize]);
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        let indices = Indices::Sequence(5);
        let strip = indices.triangles(Mode::TriangleStrip, 5).unwrap();
        assert_eq!(strip, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        let fan = indices.triangles(Mode::TriangleFan, 5).unwrap();
        assert_eq!(fan, [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
        let list = indices.triangles(Mode::Triangles, 5).unwrap();
        assert_eq!(list, [[0, 1, 2]]);
        assert!(indices.left_over(Mode::Triangles));
    }

    #[test]
    fn an_index_out_of_range_is_named() {
        let message = Indices::List(vec![0, 1, 2, 0, 1, 7])
            .triangles(Mode::Triangles, 3)
            .unwrap_err();
        assert!(message.contains("index 7 at position 5"), "{message}");
    }

    #[test]
    fn both_ways_of_compacting_agree() {
        let original = [[5, 9, 5000], [9, 5, 77]];
        let mut few = original;
        let mut many = original;
        assert_eq!(compact(&mut few, 5001), [5, 9, 5000, 77]);
        assert_eq!(compact(&mut many, 1_000_000), [5, 9, 5000, 77]);
        assert_eq!(few, many);
        assert_eq!(few, [[0, 1, 2], [1, 0, 3]]);
    }

    #[test]
    fn useless_triangles_are_counted_by_kind() {
        let positions = [
            Vec3::ZERO,
            Vec3::X,
            Vec3::Y,
            Vec3::X * 2.0,
            Vec3::NAN,
            Vec3::splat(f32::INFINITY),
        ];
        let mut list = vec![[0, 1, 2], [0, 0, 1], [0, 1, 3], [0, 1, 4], [5, 1, 2]];
        let mut dropped = Dropped::default();
        assert!(!keep_usable(&mut list, &positions, &mut dropped));
        assert_eq!(list, [[0, 1, 2]]);
        assert_eq!((dropped.degenerate, dropped.non_finite), (2, 2));
    }
}
