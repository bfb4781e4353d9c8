//! Custom attributes of meshes (glTF 2.0, section 3.7.2.1: names that begin with an underscore), for textures to read.

use super::accessor::Accessor;
use super::attributes::Attributes;
use super::document::Document;
use crate::import::error::Fault;
use crate::import::mesh::{Dropped, VALUE_BYTES};
use crate::{CustomAttribute, Mesh};
use glam::Vec4;
use gltf::json::accessor::Type;
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;
use std::collections::BTreeSet;

/// All custom attributes of the vertices `used`, sorted by name.
pub(super) fn read(
    attributes: &Attributes<'_>,
    used: &[u32],
    dropped: &mut Dropped,
) -> Result<Vec<CustomAttribute>, Fault> {
    let document = attributes.document;
    let mut custom = Vec::new();
    for (semantic, index) in &attributes.primitive.attributes {
        let Checked::Valid(semantic @ Semantic::Extras(_)) = semantic else {
            continue;
        };
        let name = semantic.to_string();
        let kind = document.root.accessors.get(index.value());
        if let Some(Checked::Valid(Type::Mat2 | Type::Mat3 | Type::Mat4)) =
            kind.map(|accessor| accessor.type_)
        {
            return Err(format!(
                "{name}: accessor {} holds matrices, custom attributes have one to four components",
                index.value()
            ));
        }
        let Some(accessor) = attributes.get(semantic.clone(), &[1, 2, 3, 4])? else {
            continue;
        };
        document.budget.take(used.len() as u64, VALUE_BYTES)?;
        custom.push(CustomAttribute {
            name,
            values: values(&accessor, used, dropped),
        });
    }
    custom.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(custom)
}

/// Makes sure that the primitives of a mesh may be joined: each will have the attributes of all.
pub(super) fn take_joined(document: &Document, parts: &[Mesh]) -> Result<(), Fault> {
    let custom = || parts.iter().flat_map(|part| &part.custom);
    let names: BTreeSet<&str> = custom().map(|attribute| attribute.name.as_str()).collect();
    let all: usize = parts.iter().map(|p| p.positions.len() * names.len()).sum();
    let there: usize = custom().map(|attribute| attribute.values.len()).sum();
    document.budget.take((all - there) as u64, VALUE_BYTES)
}

/// Values with the components that are missing; where a number is none, all of the value is 0.
fn values(accessor: &Accessor<'_>, used: &[u32], dropped: &mut Dropped) -> Vec<Vec4> {
    let has_w = accessor.components() == 4;
    let complete = |value: [f32; 4]| {
        let mut value = Vec4::from(value);
        if !has_w {
            value.w = 1.0;
        }
        if !value.is_finite() {
            dropped.bad_values += 1;
            value = Vec4::ZERO;
        }
        value
    };
    let read = accessor.gather::<4>(used.iter().copied());
    read.into_iter().map(complete).collect()
}
