//! What formats of scene files have in common: what they are asked, and what they answer.

use super::budget::Budget;
use super::error::ImportError;
use super::pictures::Pictures;
use crate::Scene;
use crate::input::Files;
use glam::DAffine3;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a format of scene files has to bring.
pub(super) trait Format: fmt::Debug + Sync {
    /// Reads a file, with all that it refers to: what it adds to a scene. Its materials refer to images by where they
    /// will stand in `Scene::images`; all other indices begin at 0.
    fn read(&self, request: Request<'_>) -> Result<Imported, ImportError>;

    /// The files beside it that it names; none where it can't be understood.
    fn referenced_files(&self, files: &dyn Files, path: &Path) -> Vec<PathBuf>;
}

/// What is to be read, and for whom.
pub(super) struct Request<'a> {
    /// Where it lies, and what it names.
    pub(super) files: &'a Arc<dyn Files>,
    pub(super) path: &'a Path,
    /// The file's world in that of the scene.
    pub(super) placement: DAffine3,
    /// What is there already.
    pub(super) scene: &'a Scene,
    /// Whether the file's environment is wanted.
    pub(super) with_environment: bool,
    /// What decoding may still take.
    pub(super) budget: &'a Arc<Budget>,
    /// The pictures that are there already.
    pub(super) pictures: &'a mut Pictures,
}

/// A scene and what the user should know about it.
#[derive(Debug)]
pub struct Imported {
    /// What was read.
    pub scene: Scene,
    /// Sentences about what is shown differently from what the file says.
    pub warnings: Vec<String>,
}
