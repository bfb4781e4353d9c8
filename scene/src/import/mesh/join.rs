//! Meshes joined to one.

use super::tangents;
use crate::{CustomAttribute, Mesh};
use glam::{Vec2, Vec3, Vec4};
use std::collections::BTreeSet;

/// Joins the primitives of a mesh. An attribute that only some of them have gets its neutral value in the others; tangents are better made
/// before.
pub(in crate::import) fn merge(mut parts: Vec<Mesh>) -> Mesh {
    if parts.len() == 1 {
        return parts.remove(0);
    }
    for_missing(&mut parts, |m| &mut m.uv0, |_| Vec2::ZERO);
    // The second set of a primitive that has one only is its first, as of a mesh that has one only.
    if parts.iter().any(|part| !part.uv1.is_empty()) {
        for part in parts.iter_mut().filter(|part| part.uv1.is_empty()) {
            part.uv1.clone_from(&part.uv0);
            // None has a first set.
            part.uv1.resize(part.positions.len(), Vec2::ZERO);
        }
    }
    for_missing(&mut parts, |m| &mut m.colors, |_| Vec4::ONE);
    for_missing(
        &mut parts,
        |m| &mut m.tangents,
        |n| tangents::sanitize(Vec4::ZERO, n),
    );
    complete_custom(&mut parts);
    let mut mesh = Mesh::default();
    for part in parts {
        let start = mesh.positions.len() as u32;
        mesh.positions.extend(part.positions);
        mesh.normals.extend(part.normals);
        mesh.tangents.extend(part.tangents);
        mesh.uv0.extend(part.uv0);
        mesh.uv1.extend(part.uv1);
        mesh.colors.extend(part.colors);
        if mesh.custom.is_empty() {
            mesh.custom = part.custom;
        } else {
            for (all, more) in mesh.custom.iter_mut().zip(part.custom) {
                all.values.extend(more.values);
            }
        }
        mesh.triangles
            .extend(part.triangles.into_iter().map(|t| t.map(|v| v + start)));
        mesh.triangle_materials.extend(part.triangle_materials);
    }
    mesh
}

/// Gives all primitives the same custom attributes in the order of their names. Where one isn't there it is 0, as in
/// a mesh that has none.
fn complete_custom(parts: &mut [Mesh]) {
    let custom = parts.iter().flat_map(|part| &part.custom);
    let names: BTreeSet<String> = custom.map(|attribute| attribute.name.clone()).collect();
    for part in parts {
        let mut there = std::mem::take(&mut part.custom).into_iter().peekable();
        let all = names.iter().map(|name| {
            let own = there.next_if(|attribute| attribute.name == *name);
            own.unwrap_or_else(|| CustomAttribute {
                name: name.clone(),
                values: vec![Vec4::ZERO; part.positions.len()],
            })
        });
        part.custom = all.collect();
    }
}

fn for_missing<T>(
    parts: &mut [Mesh],
    attribute: impl Fn(&mut Mesh) -> &mut Vec<T>,
    neutral: impl Fn(Vec3) -> T,
) {
    if parts.iter_mut().all(|part| attribute(part).is_empty()) {
        return;
    }
    for part in parts {
        if attribute(part).is_empty() {
            let values = part.normals.iter().map(|&normal| neutral(normal)).collect();
            *attribute(part) = values;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_texture_coordinates_of_a_part_without_them_are_its_first() {
        let part = |uv0: Vec2, uv1: Option<Vec2>| Mesh {
            positions: vec![Vec3::ZERO; 3],
            normals: vec![Vec3::Z; 3],
            uv0: vec![uv0; 3],
            uv1: uv1.map_or_else(Vec::new, |uv| vec![uv; 3]),
            triangles: vec![[0, 1, 2]],
            triangle_materials: vec![0],
            ..Mesh::default()
        };
        let [a, b, c] = [0.25, 0.5, 0.75].map(Vec2::splat);
        let joined = merge(vec![part(a, None), part(b, Some(c))]);
        assert_eq!(joined.uv0, [[a; 3], [b; 3]].concat());
        assert_eq!(joined.uv1, [[a; 3], [c; 3]].concat());
        let one_set = merge(vec![part(a, None), part(b, None)]);
        assert!(one_set.uv1.is_empty());
        let mut bare = part(a, None);
        bare.uv0.clear();
        let joined = merge(vec![bare, part(b, Some(c))]);
        assert_eq!(joined.uv1, [[Vec2::ZERO; 3], [c; 3]].concat());
    }
}
