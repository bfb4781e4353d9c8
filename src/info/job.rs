//! A validated job of `patina info`. Nothing is opened here.

use std::path::PathBuf;

use super::args::InfoArgs;

/// A file to be told of.
#[derive(Debug, PartialEq)]
pub(crate) struct InfoJob {
    /// Which.
    pub(crate) file: PathBuf,
    /// Of a scene.
    pub(crate) look: Option<PathBuf>,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
    /// Print JSON.
    pub(crate) json: bool,
}

impl InfoJob {
    /// Nothing of it can be wrong before the file is looked at.
    pub(crate) fn from_args(args: InfoArgs) -> Self {
        Self {
            file: args.file,
            look: args.look,
            texture_dirs: args.texture_dirs,
            json: args.json,
        }
    }
}
