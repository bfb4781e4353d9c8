//! What of the scene the textures read, besides what every hit has: it is uploaded for them.

use std::collections::{BTreeSet, HashSet};

use rayon::prelude::*;
use texgen::{Attribute, BuiltinAttribute, Diagnostic, TextureType};

use super::wiring::Wiring;
use super::{Output, Procedural};
use crate::scene::import::give_tangents;
use crate::scene::{Material, Mesh, Scene};
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

    /// Gives meshes tangents where something lies along them and their file has none: by their first texture coordinates, as glTF has it
    /// for normal maps. A kernel knows such directions of each triangle by itself; these are smooth.
    pub(crate) fn give_tangents(&mut self, scene: &mut Scene) {
        self.along_tangents = self.are_along_tangents(&scene.materials);
        let lie_along = &self.along_tangents;
        if lie_along.is_empty() {
            return;
        }
        let needs = |mesh: &&mut Mesh| {
            let mut materials = mesh.triangle_materials.iter();
            mesh.tangents.is_empty()
                && !mesh.uv0.is_empty()
                && materials.any(|material| lie_along.contains(material))
        };
        let meshes = scene.meshes.par_iter_mut().filter(needs);
        meshes.for_each(give_tangents);
    }

    /// Whether a mesh may lack tangents that something lies along now.
    pub(crate) fn lacks_tangents(&self, materials: &[Material]) -> bool {
        let lie_along = self.are_along_tangents(materials);
        !lie_along.is_subset(&self.along_tangents)
    }

    /// The materials that lie along tangents: their programs read them, or they stretch reflections.
    fn are_along_tangents(&self, materials: &[Material]) -> HashSet<u32> {
        self.readers(|material, wiring| {
            let material = materials.get(material as usize);
            let mut textures = wiring.nodes.iter().map(|&node| self.graph.texture(node));
            material.is_some_and(|material| material.anisotropy != 0.0)
                || wiring.output(Output::ANISOTROPY).is_some()
                || textures.any(reads_tangents)
        })
    }

    /// The materials whose programs read an attribute, themselves or in what they blend, and the textures that do it.
    fn readers_of<'a>(
        &'a self,
        attribute: &Attribute,
        textures: &mut BTreeSet<&'a str>,
    ) -> HashSet<u32> {
        self.readers(|_, wiring| {
            let mut reads = false;
            for &node in &wiring.nodes {
                let texture = self.graph.texture(node);
                if texture.attributes().contains(attribute) {
                    reads = true;
                    textures.insert(texture.name());
                }
            }
            reads
        })
    }

    /// The materials of which something is true, and those that blend them.
    fn readers<'a>(&'a self, mut reads: impl FnMut(u32, &'a Wiring) -> bool) -> HashSet<u32> {
        let mut readers = HashSet::new();
        for &material in &self.order {
            let wiring = &self.wiring[material as usize];
            let reads = reads(material, wiring);
            let below = wiring.blend.as_ref();
            let below = below.map_or([material; 2], |blend| [blend.base, blend.over]);
            if reads || below.iter().any(|m| readers.contains(m)) {
                readers.insert(material);
            }
        }
        readers
    }
}

/// Whether a texture reads directions along the surface.
pub(super) fn reads_tangents(texture: &TextureType) -> bool {
    let directions = [BuiltinAttribute::Tangent, BuiltinAttribute::Bitangent];
    let directions = directions.map(Attribute::Builtin);
    (texture.attributes().iter()).any(|attribute| directions.contains(attribute))
}
