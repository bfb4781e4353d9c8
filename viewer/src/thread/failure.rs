//! Failures: those that may pass are told, those that don't stop the render until something changes, and a device that is lost ends
//! it and keeps the edits.

use std::path::PathBuf;

use engine::session::SessionError;

use crate::link::{Reply, lock};

use super::{Render, publish};

/// Failures in a row after which nothing is tried until something changes.
const MOST_FAILURES: u32 = 3;

impl Render {
    /// A failure that may pass is told, and tried again; one that comes again and again waits for a change.
    pub(super) fn fail(&mut self, error: &SessionError) {
        self.failures += 1;
        let is_lost = matches!(error, SessionError::Lost(_)) || self.device.is_lost();
        match (is_lost, self.failures >= MOST_FAILURES) {
            (true, _) => self.stop(publish::message(error)),
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

    /// A device is gone: says so, and keeps what was not saved.
    pub(super) fn stop(&mut self, mut text: String) {
        if lock(&self.board).status.fatal.is_some() {
            return;
        }
        if let Some(mut session) = self.session.take()
            && session.has_unsaved_edits()
        {
            let look = session.inputs().look.clone();
            let beside = look.unwrap_or_else(|| session.inputs().scene.with_extension("look.toml"));
            let mut name = beside.into_os_string();
            name.push(".recovered");
            let path = PathBuf::from(name);
            text = match session.save(Some(&path)) {
                Ok(()) => format!("{text}\nYour edits are in {}", path.display()),
                Err(why) => format!(
                    "{text}\nYour edits could not be kept: {}",
                    publish::message(&why)
                ),
            };
        }
        lock(&self.board).status.fatal = Some(text);
        (self.wake)();
    }
}
