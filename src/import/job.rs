//! A validated job of `patina import`. Nothing is opened here.

use std::path::PathBuf;

use crate::usage::UsageError;

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
    /// Validates a command line.
    ///
    /// # Errors
    /// A name that no material of a look can have.
    pub(crate) fn from_args(args: ImportArgs) -> Result<Self, UsageError> {
        if args.name.as_deref().is_some_and(str::is_empty) {
            return Err(UsageError::EmptyName);
        }
        let stem = args.file.file_stem().unwrap_or_default();
        let beside = PathBuf::from(format!("{}.look.toml", stem.to_string_lossy()));
        Ok(Self {
            output: args.output.unwrap_or(beside),
            file: args.file,
            material: args.material,
            name: args.name,
            drafts: args.drafts,
        })
    }
}
