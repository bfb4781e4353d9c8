//! Why an invocation failed: every error that the user sees is made one of these, so that all of them look alike.

use std::fmt;

use engine::load::LoadError;
use engine::scene::look::LookError;
use engine::session::SessionError;
use texgen::Diagnostics;

use crate::usage::UsageError;

/// Why an invocation did not do what was asked.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The command line makes no sense; nothing was tried. Exit code 2.
    Usage(UsageError),
    /// It was tried and failed; the text tells why and what to do. Exit code 1.
    Failed(String),
    /// Mistakes in the user's files, each with its place. Exit code 1.
    Mistakes(Diagnostics),
    /// It was ended by a signal, and what there was has been written. Exit code 128 and the signal's number.
    Interrupted,
}

impl Failure {
    /// A failure with the text of any error.
    pub(crate) fn because(error: impl fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(error) => error.fmt(f),
            Self::Failed(text) => f.write_str(text),
            Self::Mistakes(mistakes) => f.write_str(&mistakes.render()),
            Self::Interrupted => f.write_str("interrupted"),
        }
    }
}

impl From<UsageError> for Failure {
    fn from(error: UsageError) -> Self {
        Self::Usage(error)
    }
}

impl From<Diagnostics> for Failure {
    fn from(mistakes: Diagnostics) -> Self {
        Self::Mistakes(mistakes)
    }
}

impl From<LookError> for Failure {
    fn from(error: LookError) -> Self {
        match error {
            LookError::Invalid(mistakes) => Self::Mistakes(mistakes),
            LookError::Read { .. } => Self::because(error),
        }
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        match error {
            LoadError::Look(error) => error.into(),
            _ => Self::because(error),
        }
    }
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        match error {
            SessionError::Load(error) => error.into(),
            _ => Self::because(error),
        }
    }
}
