//! What formats of scene files have in common: what they are asked, and what they answer.

use super::budget::Budget;
use super::error::ImportError;
use super::pictures::Pictures;
use crate::input::Files;
use crate::{Animation, Moment, Scene};
use glam::DAffine3;
use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a format of scene files has to bring.
pub(super) trait Format: fmt::Debug + Sync {
    /// Opens a file with all that it refers to but pictures, and with its animations where they may be asked for; what decoding
    /// takes comes out of the budget.
    fn open(
        &self,
        files: &Arc<dyn Files>,
        path: &Path,
        budget: &Arc<Budget>,
        with_animations: bool,
    ) -> Result<Arc<dyn Opened>, ImportError>;

    /// The files beside it that it names; none where it can't be understood.
    fn referenced_files(&self, files: &dyn Files, path: &Path) -> Vec<PathBuf>;
}

/// A file that is open: its scene can be read at one moment after the other.
pub(super) trait Opened: fmt::Debug + Send + Sync {
    /// What it adds to a scene. Its materials refer to images by where they will stand in `Scene::images`; all other indices
    /// begin at 0.
    fn read(&self, request: Request<'_>) -> Result<Imported, ImportError>;

    /// It is added to a scene once more, which allows for more memory.
    fn allow_again(&self);

    /// What can move it.
    fn animations(&self) -> Result<Described, ImportError>;
}

/// The animations of a file.
#[derive(Debug, Default)]
pub(super) struct Described {
    /// All of them, in the order of the file; of those that make no sense the names alone.
    pub(super) animations: Vec<Animation>,
    /// What is wrong with the first that makes none.
    pub(super) problem: Option<ImportError>,
}

/// What is to be read, and for whom.
pub(super) struct Request<'a> {
    /// The file's world in that of the scene.
    pub(super) placement: DAffine3,
    /// What is there already.
    pub(super) scene: &'a Scene,
    /// Whether the file's environment is wanted.
    pub(super) with_environment: bool,
    /// When.
    pub(super) moment: &'a Moment,
    /// Other moments follow: what looks the same then is worth keeping.
    pub(super) is_read_again: bool,
    /// The pictures that are there already.
    pub(super) pictures: &'a mut Pictures,
}

/// A scene and what the user should know about it.
#[derive(Debug, Default)]
pub struct Imported {
    /// What was read.
    pub scene: Scene,
    /// What its nodes are called, as far as the scene doesn't say it.
    pub names: NodeNames,
    /// Why the file's environment can't be read; the scene's is black then. It is no error where another one takes its place.
    pub environment_problem: Option<ImportError>,
    /// Sentences about what is shown differently from what the file says.
    pub warnings: Vec<String>,
}

/// What visible nodes are called, as far as a scene doesn't say it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct NodeNames {
    /// The node of each of the scene's lights, in their order.
    pub lights: Vec<String>,
    /// Nodes with a mesh of which nothing is in the scene: scaled to nothing at this moment, or without triangles.
    pub gone_meshes: BTreeSet<String>,
    /// Lights that aren't in the scene at this moment, of files that have animations: the node, and the light's own name.
    pub gone_lights: BTreeSet<(String, String)>,
}
