//! Why something did not happen.

use std::path::PathBuf;

use crate::load::LoadError;
use crate::renderer::RenderError;

/// Why something did not happen. The picture and the look are as before.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// What is to be rendered can't be read.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The device.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// An edit that makes no sense.
    #[error("{0}")]
    Refused(String),
    /// The device was lost and can't be opened again. The look is kept: it can be saved, and the next step tries again.
    #[error("the graphics device was lost and can't be used again: {0}; the look is kept")]
    Lost(RenderError),
    /// There is no file to save the look to.
    #[error("there is no look file to save to: name one")]
    NoFile,
    /// The file has been changed by others, and what they wrote has not become part of the look, because it is wrong or has
    /// just been written.
    #[error("{} was changed by another program; mend it there, or save under a name: the same one replaces it", path.display())]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// Somebody has said that the file is not to be changed.
    #[error("{} is read-only; save it under another name, or make it writable", path.display())]
    ReadOnly {
        /// The file.
        path: PathBuf,
    },
    /// The look can't be saved.
    #[error("cannot write the look {}: {source}", path.display())]
    Save {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}
