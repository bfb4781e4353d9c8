//! What can't be compiled, and where.

use naga::Span;

/// Why a kernel was not compiled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{kind}")]
pub struct CompileError {
    /// What is wrong.
    pub kind: ErrorKind,
    /// Where in the text; undefined where naga keeps no place.
    pub span: Span,
}

/// What is wrong with a kernel.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The module has no such entry point for compute.
    #[error("there is no compute entry point `{0}`")]
    NoEntryPoint(String),
    /// A value of an override constant doesn't fit, or is missing.
    #[error("override constants: {0}")]
    Constants(String),
    /// Something that no kernel for processors can use.
    #[error("{0}: processors can't run this")]
    Unsupported(String),
    /// A value of very many parts.
    #[error("a value of {scalars} numbers is too large; at most {most} are possible")]
    TooLarge {
        /// Numbers in it.
        scalars: u64,
        /// What is possible.
        most: u32,
    },
    /// Large arrays, or a deep chain of functions with arrays.
    #[error(
        "it needs {bytes} bytes of private memory, where {limit} are possible: use smaller arrays"
    )]
    Stack {
        /// What is needed.
        bytes: u64,
        /// What is possible.
        limit: u32,
    },
    /// The code generator refuses the function.
    #[error("machine code of `{function}`: {message}")]
    Code {
        /// The function's name.
        function: String,
        /// What it says.
        message: String,
    },
}

impl ErrorKind {
    /// What is not supported, in words.
    pub fn unsupported(what: impl Into<String>) -> CompileError {
        Self::Unsupported(what.into()).into()
    }
}

impl From<ErrorKind> for CompileError {
    fn from(kind: ErrorKind) -> Self {
        Self {
            kind,
            span: Span::UNDEFINED,
        }
    }
}

impl CompileError {
    /// The same with a place, unless it has one.
    pub fn at(mut self, span: Span) -> Self {
        if !self.span.is_defined() {
            self.span = span;
        }
        self
    }
}
