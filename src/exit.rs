//! What an invocation ends with: exit code 0 (done), 1 (failed), 2 (wrong usage) or that of a signal, and the message on
//! stderr.

use std::io::Write;
use std::process::ExitCode;

use crate::failure::Failure;
use crate::{console, interrupt};

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
