//! The attributes of a primitive, held against its positions.

use super::accessor::Accessor;
use super::document::Document;
use crate::import::error::Fault;
use gltf::json;
use json::mesh::Semantic;
use json::validation::Checked;

/// What a primitive knows of its vertices.
pub(super) struct Attributes<'a> {
    pub(super) document: &'a Document,
    pub(super) primitive: &'a json::mesh::Primitive,
}

impl<'a> Attributes<'a> {
    /// An attribute with as many elements as the positions have, and one of the given numbers of components.
    pub(super) fn get(
        &self,
        semantic: Semantic,
        components: &[usize],
    ) -> Result<Option<Accessor<'a>>, Fault> {
        let positions = self
            .primitive
            .attributes
            .get(&Checked::Valid(Semantic::Positions));
        let name = semantic.to_string();
        let Some(index) = self.primitive.attributes.get(&Checked::Valid(semantic)) else {
            return Ok(None);
        };
        let accessor = self
            .document
            .accessor(index.value())
            .map_err(|fault| format!("{name}: {fault}"))?;
        if !components.contains(&accessor.components()) {
            return Err(format!(
                "{name}: accessor {} has {} components",
                index.value(),
                accessor.components()
            ));
        }
        let vertices = match positions.and_then(|p| self.document.root.accessors.get(p.value())) {
            Some(positions) => positions.count.0,
            None => 0,
        };
        if u64::from(accessor.count()) < vertices {
            return Err(format!(
                "{name}: accessor {} has {} elements for {vertices} vertices",
                index.value(),
                accessor.count()
            ));
        }
        Ok(Some(accessor))
    }
}
