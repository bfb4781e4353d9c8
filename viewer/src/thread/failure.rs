//! Failures: those that may pass are told, those that don't stop the render until something changes, and a device that is lost ends
//! it and keeps the edits.

use std::io::Write as _;
use std::path::PathBuf;

use engine::aside;
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
        if let Some(session) = self.session.take() {
            let look = session.inputs().look.clone();
            let beside = look.unwrap_or_else(|| session.inputs().scene.with_extension("look.toml"));
            let mut name = beside.into_os_string();
            name.push(".recovered");
            self.recovered = Some(PathBuf::from(name));
            // What waits is the whole look, too.
            let waiting = self.pending.changes.take();
            let edited = match waiting.last() {
                Some(change) => Some(change.text().to_owned()),
                None => (session.has_unsaved_edits()).then(|| session.look_text()),
            };
            if let Some(said) = edited.and_then(|edited| self.recover(&edited)) {
                text = format!("{text}\n{said}");
            }
        }
        lock(&self.board).status.fatal = Some(text);
        (self.wake)();
    }

    /// Keeps a look beside its file, and says so; also what the user went on to do until it was said.
    pub(super) fn recover(&self, text: &str) -> Option<String> {
        let path = self.recovered.as_ref()?;
        let kept = aside::replace(path, |file| file.write_all(text.as_bytes()));
        Some(match kept {
            Ok(()) => format!("Your edits are in {}", path.display()),
            Err(why) => format!("Your edits could not be kept: {}: {why}", path.display()),
        })
    }
}
