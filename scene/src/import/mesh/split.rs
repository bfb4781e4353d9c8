//! Gives the corners of triangles values of their own, with as few vertices as possible.
//!
//! Flat normals and MikkTSpace tangents belong to corners, not to vertices. A vertex whose corners agree stays one.

use std::sync::Arc;

use crate::Mesh;

/// Longest list of copies of one vertex that is searched for an equal one. A vertex with more different values just
/// gets more copies, so that the time stays linear for any input.
const MAX_SEARCH: usize = 16;

const NONE: u32 = u32::MAX;

/// Rewrites `triangles` so that each vertex has one value. Returns, for each new vertex, the old vertex that it is a
/// copy of and its value.
pub(in crate::import) fn split_vertices<T: Copy + PartialEq>(
    vertex_count: usize,
    triangles: &mut [[u32; 3]],
    corner: impl Fn(usize, usize) -> T,
) -> (Vec<u32>, Vec<T>) {
    // Copies of an old vertex form a list: `first[old]`, then `next[copy]`.
    let mut first = vec![NONE; vertex_count];
    let mut next = Vec::with_capacity(vertex_count);
    let mut sources = Vec::with_capacity(vertex_count);
    let mut values: Vec<T> = Vec::with_capacity(vertex_count);
    for (index, triangle) in triangles.iter_mut().enumerate() {
        for (k, vertex) in triangle.iter_mut().enumerate() {
            let value = corner(index, k);
            let old = *vertex as usize;
            let mut copy = first[old];
            let mut steps = 0;
            while copy != NONE && values[copy as usize] != value {
                copy = if steps < MAX_SEARCH {
                    next[copy as usize]
                } else {
                    NONE
                };
                steps += 1;
            }
            if copy == NONE {
                copy = values.len() as u32;
                next.push(first[old]);
                first[old] = copy;
                sources.push(old as u32);
                values.push(value);
            }
            *vertex = copy;
        }
    }
    (sources, values)
}

/// Makes vertex `i` of all attributes a copy of the old vertex `sources[i]`.
pub(in crate::import) fn reorder(mesh: &mut Mesh, sources: &[u32]) {
    fn pick<T: Copy>(values: &mut Vec<T>, sources: &[u32]) {
        if !values.is_empty() {
            *values = sources
                .iter()
                .map(|&source| values[source as usize])
                .collect();
        }
    }
    pick(&mut mesh.positions, sources);
    pick(&mut mesh.normals, sources);
    pick(&mut mesh.tangents, sources);
    pick(&mut mesh.uv0, sources);
    pick(&mut mesh.uv1, sources);
    pick(&mut mesh.colors, sources);
    for attribute in &mut mesh.custom {
        pick(&mut attribute.values, sources);
    }
    if let Some(unbent) = &mut mesh.unbent {
        pick(Arc::make_mut(unbent), sources);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_corners_stay_one_vertex_and_different_ones_part() {
        let mut triangles = [[0, 1, 2], [0, 2, 3], [3, 2, 4]];
        let value = [7, 7, 9];
        let (sources, values) = split_vertices(5, &mut triangles, |t, _| value[t]);
        assert_eq!(sources, [0, 1, 2, 3, 3, 2, 4]);
        assert_eq!(values, [7, 7, 7, 7, 9, 9, 9]);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6]]);
    }

    #[test]
    fn a_fan_of_a_million_different_values_takes_no_time() {
        let mut triangles: Vec<[u32; 3]> = (0..1_000_000).map(|i| [0, i + 1, i + 2]).collect();
        let (sources, _) = split_vertices(1_000_002, &mut triangles, |t, _| t);
        assert_eq!(sources.len(), 3_000_000);
    }
}
