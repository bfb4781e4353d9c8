//! Lists of triangles, down to those that can be rendered.

use super::Dropped;
use glam::Vec3;
use std::collections::HashMap;

/// Renumbers vertices in order of first use and returns the old number of each.
pub(in crate::import) fn compact(triangles: &mut [[u32; 3]], vertex_count: u32) -> Vec<u32> {
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
pub(in crate::import) fn keep_usable(
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
pub(in crate::import) fn cross([a, b, c]: [u32; 3], positions: &[Vec3]) -> Vec3 {
    let [a, b, c] = [a, b, c].map(|v| positions[v as usize]);
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

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
