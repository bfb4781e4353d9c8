//! How the picture is shown: the command line counts more than the look, and the look more than what was chosen last. What is
//! changed above the picture changes where it was read from.

use engine::display::DisplaySettings;
use engine::scene::look::{Section, Value};
use engine::scene::view::{View, ViewChoice};
use engine::session::Edit;

use crate::link::Command;

use super::Viewer;

/// Edits of exposures that follow each other are one step of the history.
const EXPOSURE: u64 = 0x0e0_5e7;

impl Viewer {
    /// What the look says of the view.
    fn look_view(&mut self) -> ViewChoice {
        let document = self.document_mut();
        document.map_or_else(ViewChoice::default, |document| document.look().view)
    }

    /// Shows the picture as command line, look and preferences have it now.
    pub(super) fn show_view(&mut self) {
        let said = self.given_view.or(self.look_view());
        let view = said.over(self.preferences.view());
        self.send_display(DisplaySettings {
            view,
            ..self.display
        });
    }

    /// Shows the picture in another way, and keeps that.
    pub(super) fn set_display(&mut self, display: DisplaySettings) {
        let View {
            exposure,
            transform,
            ..
        } = display.view;
        let look = self.look_view();
        if exposure != self.display.view.exposure {
            let number = Value::number(exposure);
            match (&mut self.given_view.exposure, look.exposure) {
                (Some(given), _) => *given = exposure,
                (None, Some(_)) => self.edit_view("exposure", number, Some(EXPOSURE)),
                (None, None) => self.preferences.exposure = exposure,
            }
        }
        if transform != self.display.view.transform {
            let name = transform.name().to_owned();
            match (&mut self.given_view.transform, look.transform) {
                (Some(given), _) => *given = transform,
                (None, Some(_)) => self.edit_view("transform", Value::Text(name), None),
                (None, None) => self.preferences.view = name,
            }
        }
        self.send_display(display);
    }

    fn edit_view(&mut self, key: &str, value: Value, group: Option<u64>) {
        if let Some(document) = self.document_mut() {
            // A constant would take its keys away.
            let written = document.value(&Section::View, key);
            if written.is_some_and(|value| value.has_keys()) {
                return;
            }
            // Refused, it goes on being shown as it was.
            let _ = document.apply("view", &[Edit::view(key, value)], group);
        }
    }

    fn send_display(&mut self, display: DisplaySettings) {
        if display != self.display {
            self.display = display;
            self.link.send(Command::Display(display));
        }
    }
}
