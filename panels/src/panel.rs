//! The textures panel: what belongs to one material, as a list or as a graph.

use engine::scene::Material;

use crate::{Document, Textures};

/// What the panel needs to know about the scene that is shown.
#[derive(Debug, Clone, Copy)]
pub struct SceneView<'a> {
    /// Materials as they are shown, constants of the look included.
    pub materials: &'a [Material],
}

/// The textures panel.
#[derive(Debug, Default)]
pub struct TexturesPanel {
    material: Option<String>,
    /// Why the last edit was refused.
    message: Option<String>,
}

impl TexturesPanel {
    /// Shows a material, as when it was clicked in the picture.
    pub fn pick(&mut self, material: &str) {
        self.material = Some(material.to_owned());
    }

    /// The material that is shown.
    pub fn material(&self) -> Option<&str> {
        self.material.as_deref()
    }

    /// Shows the panel. Edits are made in `document`; [`Document::take_changes`] tells the renderer.
    pub fn show(
        &mut self,
        ui: &mut egui::Ui,
        document: &mut Document,
        textures: &Textures,
        scene: SceneView<'_>,
    ) {
        let _ = (textures, scene, &self.message);
        ui.label(document.path().display().to_string());
    }
}
