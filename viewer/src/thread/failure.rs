//! Failures: those that may pass are told, those that don't stop the render until something changes, and a device that is lost, or a
//! fault of Patina's own, ends it and keeps the edits.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::Receiver;

use engine::session::{Recovery, SessionError};

use crate::link::{Command, Files, Reply, lock};

use super::{Render, publish};

/// Failures in a row after which nothing is tried until something changes.
const MOST_FAILURES: u32 = 3;
/// Faults of Patina's own after which the thread ends: with nothing left to render they would come again and again.
const MOST_FAULTS: u32 = 16;

impl Render {
    /// Runs until there is nothing more to do. Where Patina itself has a fault, the render ends as if its device were lost: the edits are
    /// kept, also those that come afterwards, and the window says what has happened.
    pub(super) fn run_guarded(&mut self, commands: &Receiver<Command>, mut files: Option<Files>) {
        for _ in 0..MOST_FAULTS {
            // What it was at is dropped, and nothing else of it is used again but the text of the look.
            let run = AssertUnwindSafe(|| self.run(commands, files.take()));
            let Err(panic) = catch_unwind(run) else {
                return;
            };
            let text = format!(
                "Patina has a fault, and renders nothing until files are opened again: {}",
                said(&*panic)
            );
            // It may have been about to open files.
            self.is_unheard = false;
            lock(&self.board).status.is_loading = false;
            let told = text.clone();
            let stop = AssertUnwindSafe(|| self.stop(told));
            if catch_unwind(stop).is_err() {
                lock(&self.board).status.fatal = Some(text);
                (self.wake)();
            }
        }
    }

    /// A failure that may pass is told, and tried again; one that comes again and again waits for a change.
    pub(super) fn fail(&mut self, error: &SessionError) {
        self.failures += 1;
        let is_lost = matches!(error, SessionError::Lost(_)) || self.device.is_lost();
        match (is_lost, self.failures >= MOST_FAILURES) {
            (true, _) => {
                self.stop(publish::message(error));
            }
            (false, false) => self.reply(Reply::Failed(publish::message(error))),
            (false, true) => {
                self.is_stuck = true;
                let why = publish::message(error);
                let text = format!(
                    "{why}
It is tried again as soon as something changes."
                );
                lock(&self.board).status.stuck = Some(text);
                (self.wake)();
            }
        }
    }

    /// A turn went well.
    pub(super) fn go_on(&mut self) {
        if self.failures > 0 && !self.is_stuck {
            self.failures = 0;
            lock(&self.board).status.stuck = None;
            (self.wake)();
        }
    }

    /// Nothing can be rendered any more: says why, and keeps what was not saved. Gives what is said of that.
    pub(super) fn stop(&mut self, mut text: String) -> Option<String> {
        if lock(&self.board).status.fatal.is_some() {
            return None;
        }
        let mut kept = None;
        if let Some(session) = self.session.take() {
            self.recovery = Some(Recovery::of(session.inputs()));
            // What waits is the whole look, too.
            let waiting = self.pending.changes.take();
            let edited = match waiting.last() {
                Some(change) => Some(change.text().to_owned()),
                None => (session.has_unsaved_edits()).then(|| session.look_text()),
            };
            kept = edited.and_then(|edited| self.recover(&edited));
            if let Some(said) = &kept {
                text = format!("{text}\n{said}");
            }
        }
        lock(&self.board).status.fatal = Some(text);
        (self.wake)();
        kept
    }

    /// The program is to end, as by a signal: keeps what was not saved, and has the window close.
    pub(super) fn end(&mut self) {
        if lock(&self.board).status.is_ending {
            return;
        }
        let kept = self.stop("ended by a signal".to_owned());
        self.host.ends(kept.as_deref());
        lock(&self.board).status.is_ending = true;
        (self.wake)();
    }

    /// Keeps a look in a file of its own, and says so; also what the user went on to do until it was said.
    pub(super) fn recover(&mut self, text: &str) -> Option<String> {
        let kept = self.recovery.as_mut()?.keep(text);
        Some(match kept {
            Ok(path) => format!("Your edits are in {}", path.display()),
            Err(why) => format!("Your edits could not be kept: {why}"),
        })
    }
}

/// What a panic says.
fn said(panic: &(dyn Any + Send)) -> &str {
    let literal = panic.downcast_ref::<&str>().copied();
    let text = || panic.downcast_ref::<String>().map(String::as_str);
    literal.or_else(text).unwrap_or("a panic that says nothing")
}
