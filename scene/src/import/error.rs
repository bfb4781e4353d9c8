//! Why a file could not be imported, in words that tell the user what to do next.
//!
//! Inner functions return a [`Fault`], a sentence without a place; the caller that knows where in the file it
//! stands turns it into an [`ImportError`].

use std::path::{Path, PathBuf};

/// Import of a scene or of an environment picture failed.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// A file is missing or cannot be read.
    #[error("cannot read {}: {source}{}", path.display(), crate::input::remedy(source))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The JSON of the file is not glTF 2.0.
    #[error("{}: not valid glTF JSON: {source}; export the file again", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Line, column and what was expected there.
        source: serde_json::Error,
    },
    /// The file breaks a rule of its format that rendering depends on.
    #[error("{}: {place}: {problem}; repair the file or export it again", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in the file: mesh and primitive, node, accessor, ...
        place: String,
        /// What is wrong there.
        problem: String,
    },
    /// The file can't be shown without an extension that is not supported.
    #[error("{}: needs the glTF extension {extension}, which is not supported; {remedy}", path.display())]
    Extension {
        /// The file.
        path: PathBuf,
        /// Name of the extension.
        extension: String,
        /// What the user can do.
        remedy: &'static str,
    },
    /// A picture cannot be read or decoded.
    #[error("{}: {image}: {problem}; put a picture there, saved as PNG, JPEG or WebP", path.display())]
    Image {
        /// The file that uses the picture.
        path: PathBuf,
        /// Which picture.
        image: String,
        /// What is wrong with it.
        problem: String,
    },
    /// An environment picture cannot be read or decoded.
    #[error("{}: {problem}; save it again as a scan-line RGB OpenEXR, or a Radiance HDR file of RGBE whose rows run from the top", path.display())]
    Environment {
        /// The picture.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// The content is larger than what can be held.
    #[error("{}: {problem}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What is too large, the limit, and the remedy.
        problem: String,
    },
}

/// One sentence about what is wrong, without the place.
pub(super) type Fault = String;

/// Gives a [`Fault`] its place.
pub(super) trait At<T> {
    /// Names file and place; `place` is only evaluated on failure.
    fn at(self, path: &Path, place: impl FnOnce() -> String) -> Result<T, ImportError>;
}

impl<T> At<T> for Result<T, Fault> {
    fn at(self, path: &Path, place: impl FnOnce() -> String) -> Result<T, ImportError> {
        self.map_err(|problem| ImportError::Malformed {
            path: path.to_owned(),
            place: place(),
            problem,
        })
    }
}

/// How many different warnings are kept; a damaged file could give one per node.
const MAX_WARNINGS: usize = 64;

/// Things the user should know although the import went on. Equal ones are kept once.
#[derive(Debug, Clone, Default)]
pub(super) struct Warnings {
    list: Vec<String>,
    left_out: usize,
}

impl Warnings {
    pub(super) fn push(&mut self, warning: impl Into<String>) {
        let warning = warning.into();
        if self.list.contains(&warning) {
            return;
        }
        if self.list.len() < MAX_WARNINGS {
            self.list.push(warning);
        } else {
            self.left_out += 1;
        }
    }

    pub(super) fn extend(&mut self, other: Warnings) {
        self.left_out += other.left_out;
        for warning in other.list {
            self.push(warning);
        }
    }

    pub(super) fn into_vec(mut self) -> Vec<String> {
        if self.left_out > 0 {
            self.list
                .push(format!("and {} more warnings", self.left_out));
        }
        self.list
    }
}
