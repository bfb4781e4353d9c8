//! Meshes joined to one.

use super::tangents;
use crate::{CustomAttribute, Mesh};
use glam::{Vec2, Vec3, Vec4};
use std::collections::BTreeSet;

/// Joins the primitives of a mesh. An attribute that only some of them have gets its neutral value in the others.
pub(in crate::import) fn merge(mut parts: Vec<Mesh>) -> Mesh {
    if parts.len() == 1 {
        return parts.remove(0);
    }
    for_missing(&mut parts, |m| &mut m.uv0, |_| Vec2::ZERO);
    for_missing(&mut parts, |m| &mut m.uv1, |_| Vec2::ZERO);
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
