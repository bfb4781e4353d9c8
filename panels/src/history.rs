//! What has been done to the look: a list to go back and forth in, and three states of the look that are kept aside.

use std::collections::BTreeSet;

use egui::{RichText, ScrollArea, Ui};
use engine::session::Document;

use crate::widgets;

/// Points that the list takes at most, then it scrolls.
const HEIGHT: f32 = 360.0;
const NAMES: [&str; 3] = ["A", "B", "C"];

/// A menu with all steps: a click goes there. Whether the look is another one now.
pub(crate) fn history(ui: &mut Ui, document: &mut Document) -> bool {
    let mut wanted = None;
    let menu = widgets::menu(ui, "History", |ui| {
        ui.set_min_width(180.0);
        let done = document.done();
        ScrollArea::vertical().max_height(HEIGHT).show(ui, |ui| {
            let steps = std::iter::once("As it was opened").chain(document.steps());
            for (number, step) in steps.enumerate() {
                let text = match number <= done {
                    true => RichText::new(step),
                    false => RichText::new(step).weak(),
                };
                let entry = ui.selectable_label(number == done, text);
                // A label of the panel may be called the same.
                widgets::name(&entry, &format!("Step {number}: {step}"));
                if entry.clicked() {
                    wanted = Some(number);
                }
            }
        });
    });
    let hint = "all that was done to the look: a click goes back there, or forth";
    menu.response.on_hover_text(hint);
    wanted.is_some_and(|done| document.go_to(done))
}

/// A state of a look that is kept aside.
#[derive(Debug)]
struct Snapshot {
    text: String,
    /// What it has of other programs: see [`Document::others`].
    others: BTreeSet<u64>,
}

impl Snapshot {
    fn of(document: &Document) -> Self {
        Self {
            text: document.text().to_owned(),
            others: document.others().clone(),
        }
    }
}

/// States of a look that are kept aside.
#[derive(Debug, Default)]
pub(crate) struct Snapshots {
    kept: [Option<Snapshot>; 3],
    /// The picture of now is to be compared with that of the state that was switched to.
    pub(crate) compares: bool,
}

impl Snapshots {
    /// A button for each: the first click keeps the look as it is now, later ones go back to that. Says why the look can't be what it
    /// was.
    pub(crate) fn show(&mut self, ui: &mut Ui, document: &mut Document) -> Option<String> {
        let mut refused = None;
        for (name, kept) in NAMES.into_iter().zip(&mut self.kept) {
            let is_shown = (kept.as_ref()).is_some_and(|kept| kept.text == document.text());
            let text = match kept {
                Some(_) => RichText::new(name).strong(),
                None => RichText::new(name).weak(),
            };
            let button = ui.selectable_label(is_shown, text);
            widgets::name(&button, &format!("Snapshot {name}"));
            let is_clicked = button.clicked();
            let mut is_compared = false;
            let was_kept = kept.is_some();
            if is_clicked && !was_kept {
                *kept = Some(Snapshot::of(document));
            }
            let hint = match kept {
                Some(_) => format!("shows the look as it was kept as {name}; right-click for more"),
                None => format!("keeps the look as it is now as {name}"),
            };
            let is_there = kept.is_some();
            let button = button.on_hover_text(hint);
            widgets::context_menu(&button, |ui| {
                let compare = egui::Button::new(format!("Compare with {name}"));
                if ui.add_enabled(is_there && !is_shown, compare).clicked() {
                    is_compared = true;
                    ui.close();
                }
                if ui
                    .button(format!("Keep the look of now as {name}"))
                    .clicked()
                {
                    *kept = Some(Snapshot::of(document));
                    ui.close();
                }
                let forget = egui::Button::new(format!("Forget {name}"));
                if ui.add_enabled(is_there, forget).clicked() {
                    *kept = None;
                    ui.close();
                }
            });
            if let Some(Snapshot { text, others }) = kept
                && (is_compared || is_clicked && was_kept)
            {
                let label = format!("snapshot {name}");
                let replaced = document.return_to(&label, text, others);
                self.compares |= is_compared && replaced.is_ok();
                refused = replaced.err().map(|problems| problems.to_string());
            }
        }
        refused
    }
}
