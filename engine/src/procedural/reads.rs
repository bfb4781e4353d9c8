//! What of the scene the textures read, besides what every hit has: it is uploaded for them.

use std::collections::{BTreeSet, HashSet};

use texgen::{Attribute, Diagnostic};

use super::Procedural;
use crate::scene::Scene;
use crate::texturing::TextureReads;

impl Procedural {
    /// What of the scene the textures read.
    pub fn reads(&self) -> TextureReads<'_> {
        TextureReads {
            images: &self.textures,
            with_levels: &self.images_with_levels,
            attributes: &self.custom_attributes,
        }
    }

    /// Warns of each custom attribute that a texture reads on meshes that don't have it.
    pub(super) fn warn_of_missing_attributes(&mut self, scene: &Scene) {
        for name in &self.custom_attributes {
            let mut textures = BTreeSet::new();
            let readers = self.readers_of(&Attribute::Custom(name.clone()), &mut textures);
            let is_shown: HashSet<u32> = scene.instances.iter().map(|i| i.mesh).collect();
            let meshes: Vec<bool> = (0..)
                .zip(&scene.meshes)
                .filter(|(index, _)| is_shown.contains(index))
                .filter(|(_, mesh)| mesh.triangle_materials.iter().any(|m| readers.contains(m)))
                .map(|(_, mesh)| mesh.custom(name).is_some())
                .collect();
            let missing = meshes.iter().filter(|&&is_there| !is_there).count();
            if missing > 0 {
                let textures: Vec<String> = textures.iter().map(|t| format!("`{t}`")).collect();
                let message = format!(
                    "{missing} of the {} meshes on which {} reads the attribute {name} don't have it: it is 0 there",
                    meshes.len(),
                    textures.join(", "),
                );
                self.warnings.push(Diagnostic::warning(message));
            }
        }
    }

    /// The materials whose programs read an attribute, themselves or in what they blend, and the textures that do it.
    fn readers_of<'a>(
        &'a self,
        attribute: &Attribute,
        textures: &mut BTreeSet<&'a str>,
    ) -> HashSet<u32> {
        let mut readers = HashSet::new();
        for &material in &self.order {
            let wiring = &self.wiring[material as usize];
            let mut reads = false;
            for &node in &wiring.nodes {
                let texture = self.graph.texture(node);
                if texture.attributes().contains(attribute) {
                    reads = true;
                    textures.insert(texture.name());
                }
            }
            let below = wiring.blend.as_ref();
            let below = below.map_or([material; 2], |blend| [blend.base, blend.over]);
            if reads || below.iter().any(|m| readers.contains(m)) {
                readers.insert(material);
            }
        }
        readers
    }
}
