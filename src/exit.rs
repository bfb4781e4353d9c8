//! What an invocation ends with: exit code 0 (done), 1 (failed) or 2 (wrong usage), and the message on stderr.
//!
//! Every error the user sees passes through here, so that all of them look alike.

use std::fmt;
use std::process::ExitCode;

use crate::console;
use crate::job::UsageError;

/// Why an invocation did not do what was asked.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The command line makes no sense; nothing was tried. Exit code 2.
    Usage(UsageError),
    /// It was tried and failed; the text tells why and what to do. Exit code 1.
    Failed(String),
}

impl Failure {
    /// A failure with the text of any error.
    pub(crate) fn because(error: impl fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<UsageError> for Failure {
    fn from(error: UsageError) -> Self {
        Self::Usage(error)
    }
}

/// The exit code of an outcome; prints the error, if any.
pub(crate) fn with(outcome: Result<(), Failure>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Usage(error)) => {
            console::error(&format!("{error}\n\nFor more information, try '--help'."));
            ExitCode::from(2)
        }
        Err(Failure::Failed(text)) => {
            console::error(&text);
            ExitCode::from(1)
        }
    }
}

/// The exit code of what clap answers instead of arguments: help and version (0) or a usage error (2).
pub(crate) fn with_clap(answer: &clap::Error) -> ExitCode {
    // A closed pipe (`patina --help | head -1`) is no failure.
    let _ = answer.print();
    if answer.use_stderr() {
        ExitCode::from(2)
    } else {
        ExitCode::SUCCESS
    }
}
