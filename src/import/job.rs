//! A validated job of `patina import`. Nothing is opened here.

use std::path::PathBuf;

use super::args::ImportArgs;

/// A document to be turned into a look.
#[derive(Debug, PartialEq)]
pub(crate) struct ImportJob {
    /// The document.
    pub(crate) file: PathBuf,
    /// The look.
    pub(crate) output: PathBuf,
    /// Only this material.
    pub(crate) material: Option<String>,
    /// What it is called in the look.
    pub(crate) name: Option<String>,
    /// Whether drafts are read, too.
    pub(crate) drafts: bool,
}

impl ImportJob {
    /// Nothing of it can be wrong before the document is read.
    pub(crate) fn from_args(args: ImportArgs) -> Self {
        let stem = args.file.file_stem().unwrap_or_default();
        let beside = PathBuf::from(format!("{}.look.toml", stem.to_string_lossy()));
        Self {
            output: args.output.unwrap_or(beside),
            file: args.file,
            material: args.material,
            name: args.name,
            drafts: args.drafts,
        }
    }
}
