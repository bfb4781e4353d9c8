//! What the panels know of the scene that is shown, and what they want of its picture.

use engine::scene::{Camera, Material, PunctualLight};

use crate::model_image::ModelImage;

/// What the panel needs to know about the scene that is shown.
#[derive(Debug, Clone, Copy)]
pub struct SceneView<'a> {
    /// Materials as they are shown, constants of the look included: those of the scene's files, then those that the
    /// look has added.
    pub materials: &'a [Material],
    /// So many of them are those of the scene's files.
    pub own: usize,
    /// Images of the model, by the numbers that materials have of them.
    pub images: &'a [ModelImage],
    /// Lights as they are shown, those of the look included.
    pub lights: &'a [PunctualLight],
    /// What it is looked at through, where that is known.
    pub camera: Option<&'a Camera>,
}

/// What a click into the picture is to do to a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Placing {
    /// It shines there from where it is.
    Aim,
    /// It stands in front of the surface that is there, and shines on it.
    InFront,
}
