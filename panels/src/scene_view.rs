//! What the panels know of the scene that is shown.

use engine::scene::Material;

/// What the panel needs to know about the scene that is shown.
#[derive(Debug, Clone, Copy)]
pub struct SceneView<'a> {
    /// Materials as they are shown, constants of the look included: those of the scene's files, then those that the
    /// look has added.
    pub materials: &'a [Material],
    /// So many of them are those of the scene's files.
    pub own: usize,
    /// Names of the scene's directional lights.
    pub suns: &'a [String],
}
