//! A validated job of `patina export`. Nothing is opened here.

use std::path::PathBuf;

use crate::bake::job::FineJob;
use crate::usage::UsageError;

use super::args::ExportArgs;

/// A scene to be written.
#[derive(Debug, PartialEq)]
pub(crate) struct GltfJob {
    /// The scene.
    pub(crate) scene: PathBuf,
    /// Its look.
    pub(crate) look: Option<PathBuf>,
    /// The new file.
    pub(crate) output: PathBuf,
    /// How finely.
    pub(crate) fine: FineJob,
}

impl GltfJob {
    pub(crate) fn from_args(args: ExportArgs) -> Result<Self, UsageError> {
        if args.output == args.scene || args.look.as_ref() == Some(&args.output) {
            return Err(UsageError::OverwritesInput { path: args.output });
        }
        let ending = args.output.extension();
        if !ending.is_some_and(|ending| ending.eq_ignore_ascii_case("glb")) {
            return Err(UsageError::Exported { path: args.output });
        }
        Ok(Self {
            scene: args.scene,
            look: args.look,
            output: args.output,
            fine: FineJob::from_args(args.fine, false)?,
        })
    }
}
