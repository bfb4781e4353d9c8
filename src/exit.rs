//! What an invocation ends with: exit code 0 (done), 1 (failed), 2 (wrong usage) or that of a signal, and the message on
//! stderr.
//!
//! Every error the user sees passes through here, so that all of them look alike.

use std::fmt;
use std::io::Write;
use std::process::ExitCode;

use engine::load::LoadError;
use engine::scene::look::LookError;
use engine::session::SessionError;
use texgen::Diagnostics;

use crate::job::UsageError;
use crate::{console, interrupt};

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

/// The exit code of an outcome; prints the error, if any.
pub(crate) fn with(outcome: Result<(), Failure>) -> ExitCode {
    let outcome = match (outcome, console::failure()) {
        (Ok(()), Some(broken)) => Err(Failure::Failed(broken)),
        (outcome, _) => outcome,
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Interrupted) => interrupt::leave(),
        Err(Failure::Usage(error)) => {
            let hint = match console::is_json() {
                true => "",
                false => "\n\nFor more information, try '--help'.",
            };
            console::error(&format!("{error}{hint}"));
            ExitCode::from(2)
        }
        Err(Failure::Mistakes(mistakes)) => {
            console::diagnostics(&mistakes);
            ExitCode::from(1)
        }
        Err(Failure::Failed(text)) => {
            console::error(&text);
            ExitCode::from(1)
        }
    }
}

/// The exit code of what clap answers instead of arguments: help and version (0) or a usage error (2).
pub(crate) fn with_clap(answer: &clap::Error) -> ExitCode {
    if console::is_json() && answer.use_stderr() {
        console::error(&answer.render().to_string());
    } else {
        let printed = answer.print();
        if !answer.use_stderr() {
            console::stdout_outcome(printed.and_then(|()| std::io::stdout().flush()));
        }
    }
    match answer.use_stderr() {
        true => ExitCode::from(2),
        false => with(Ok(())),
    }
}
