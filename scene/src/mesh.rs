//! Geometry and its places in the world.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3, Vec4};

/// An indexed triangle mesh in object space. All attribute vectors are as long as `positions`, or empty where
/// the mesh has no such attribute (`normals` is never empty).
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Name in the file, or a made-up one.
    pub name: String,
    /// Metres, object space; finite.
    pub positions: Vec<Vec3>,
    /// Unit length, object space.
    pub normals: Vec<Vec3>,
    /// Unit tangent and handedness (+1 or -1) as glTF defines; present where the file had tangents, where a
    /// material has a normal map, and where something of a look lies along them.
    pub tangents: Vec<Vec4>,
    /// TEXCOORD_0.
    pub uv0: Vec<Vec2>,
    /// TEXCOORD_1.
    pub uv1: Vec<Vec2>,
    /// COLOR_0, linear RGBA.
    pub colors: Vec<Vec4>,
    /// Attributes whose names begin with an underscore, sorted by name; none of them is empty.
    pub custom: Vec<CustomAttribute>,
    /// Vertex indices of each triangle; all in range, no two equal.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`](crate::Scene::materials) of each triangle; as long as `triangles`.
    pub triangle_materials: Vec<u32>,
    /// Positions of the same vertices before they are bent, where the mesh is at a moment of an animation: what is sorted by place
    /// can be sorted by these once, for all moments. As long as `positions`.
    pub unbent: Option<Arc<Vec<Vec3>>>,
}

/// A custom attribute of a mesh (glTF 2.0, section 3.7.2.1), read by textures.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CustomAttribute {
    /// As glTF and textures call it, underscore included: `_WETNESS`.
    pub name: String,
    /// One per vertex, finite. Components that the file doesn't have are those of (0, 0, 0, 1).
    pub values: Vec<Vec4>,
}

/// A mesh placed in the world.
#[derive(Debug, Clone)]
pub struct Instance {
    /// Name of the node in the file.
    pub name: String,
    /// Index into [`Scene::meshes`](crate::Scene::meshes).
    pub mesh: u32,
    /// Object to world; invertible. May mirror and scale non-uniformly.
    pub transform: Affine3A,
    /// Name of the topmost node that it hangs below, where that is another one.
    pub asset: Option<Arc<str>>,
}

impl Instance {
    /// Name of the whole that it is a piece of: of the topmost node above it, or its own.
    pub fn asset(&self) -> &str {
        self.asset.as_deref().unwrap_or(&self.name)
    }
}

impl Mesh {
    /// The custom attribute of that name.
    pub fn custom(&self, name: &str) -> Option<&CustomAttribute> {
        self.custom.iter().find(|attribute| attribute.name == name)
    }
}
