//! A texture type: one user file, parsed, checked and ready to be emitted any number of times.

use std::collections::BTreeSet;

use crate::attribute::{Attribute, Global};
use crate::diagnostic::{Diagnostic, Diagnostics, SourceFile};
use crate::interface::Parameter;
use crate::value::OutputType;

/// A valid user texture.
#[derive(Clone, Debug)]
pub struct TextureType {
    pub(crate) file: SourceFile,
    pub(crate) docs: String,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) output: OutputType,
    pub(crate) attributes: BTreeSet<Attribute>,
    pub(crate) globals: BTreeSet<Global>,
    pub(crate) warnings: Diagnostics,
}

impl TextureType {
    /// Parses and checks a user texture. The file's name is the texture's name.
    ///
    /// # Errors
    /// Everything that is wrong with the file, each with its place and a remedy.
    pub fn parse(file: SourceFile) -> Result<Self, Diagnostics> {
        Err(Diagnostic::error(format!("texture `{}` can't be parsed yet", file.name())).into())
    }

    /// The texture's name: what a look file calls it.
    pub fn name(&self) -> &str {
        self.file.name()
    }

    /// Its source.
    pub fn file(&self) -> &SourceFile {
        &self.file
    }

    /// The text of its `///` comment without the `@param` lines.
    pub fn docs(&self) -> &str {
        &self.docs
    }

    /// The parameters of `userProc` in their order.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// What `userProc` returns.
    pub fn output(&self) -> OutputType {
        self.output
    }

    /// The attributes it reads anywhere in the file.
    pub fn attributes(&self) -> &BTreeSet<Attribute> {
        &self.attributes
    }

    /// The globals it reads anywhere in the file.
    pub fn globals(&self) -> &BTreeSet<Global> {
        &self.globals
    }

    /// What is odd but not wrong: unknown keys in `@param` lines and the like.
    pub fn warnings(&self) -> &Diagnostics {
        &self.warnings
    }
}
