//! What is wrong with the files, and what has happened: over the picture, which keeps its size and so its samples.

use std::time::Duration;

use egui::{Align2, Area, Frame, Id, Label, Order, Rect, RichText, ScrollArea, Ui, vec2};

use crate::link::{Command, Status};

use super::Viewer;

/// Points between the edge of the picture and what lies over it.
const MARGIN: f32 = 8.0;
/// Of the picture's height, that problems take at most.
const MOST: f32 = 0.45;

/// Whether problems are shown in full.
#[derive(Debug, Default)]
pub(super) struct Problems {
    is_folded: bool,
    /// What they said when they were folded: others are shown.
    text: String,
    /// Points that they take.
    height: f32,
}

/// All that is wrong, each with its place.
fn texts(status: &Status) -> String {
    let Status {
        fatal,
        stuck,
        refused,
        problems,
        ..
    } = status;
    let all = [fatal, stuck, refused].into_iter().flatten();
    let all = all.chain([problems]).map(|text| text.trim_end());
    let all: Vec<&str> = all.filter(|text| !text.is_empty()).collect();
    all.join("\n\n")
}

impl Viewer {
    /// What is wrong stays until it is mended; it can be folded to a line.
    pub(super) fn problems(&mut self, ui: &Ui, picture: Rect) {
        let text = texts(&self.status);
        if text != self.problems.text {
            self.problems = Problems {
                text,
                ..Problems::default()
            };
        }
        let Problems {
            is_folded,
            text,
            height,
        } = &mut self.problems;
        if text.is_empty() {
            return;
        }
        let what = match self.status.refused {
            Some(_) => "The files have mistakes. Once they are mended, they are shown:",
            None => "The picture is not that of the files as they are:",
        };
        let width = picture.width() - 2.0 * MARGIN;
        let area = Area::new(Id::unique("problems"))
            .order(Order::Middle)
            .fixed_pos(picture.left_bottom() + vec2(MARGIN, -MARGIN))
            .pivot(Align2::LEFT_BOTTOM)
            .constrain(false);
        let shown = area.show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_width(width - 2.0 * MARGIN);
                let color = ui.visuals().error_fg_color;
                ui.horizontal(|ui| {
                    let button = match is_folded {
                        true => "Show",
                        false => "Hide",
                    };
                    *is_folded ^= ui.small_button(button).clicked();
                    ui.colored_label(color, what);
                });
                if *is_folded {
                    return;
                }
                let most = MOST * picture.height();
                // The area has as much room as it took last: all of the text is to be seen, as long as it isn't more than that.
                let scroll = ScrollArea::both()
                    .max_height(most)
                    .min_scrolled_height(most)
                    .auto_shrink([false, true]);
                scroll.show(ui, |ui| {
                    let text = RichText::new(text.as_str()).monospace().color(color);
                    ui.add(Label::new(text).selectable(true).extend());
                });
            });
        });
        *height = shown.response.rect.height() + MARGIN;
    }

    /// A light that nobody asked for is no part of the model: that is said, and it can be turned off. The look has nothing of it.
    pub(super) fn stand_in_light(&mut self, ui: &Ui, picture: Rect) {
        if !self.editor.has_stand_in_light() {
            return;
        }
        let area = Area::new(Id::unique("stand-in light"))
            .order(Order::Middle)
            .fixed_pos(picture.right_top() + vec2(-MARGIN, MARGIN))
            .pivot(Align2::RIGHT_TOP);
        let mut is_on = self.preferences.studio_light;
        area.show(ui.ctx(), |ui| {
            let row = |ui: &mut Ui| {
                ui.label("No light in the files");
                let switch = ui.checkbox(&mut is_on, "Studio light");
                switch.on_hover_text(
                    "of this window alone: the look and pictures of `patina render` have nothing of it",
                );
            };
            Frame::popup(ui.style()).show(ui, |ui| ui.horizontal(row));
        });
        if is_on != self.preferences.studio_light {
            self.preferences.studio_light = is_on;
            self.link.send(Command::StudioLight(is_on));
        }
    }

    /// Messages lie over the picture and vanish.
    pub(super) fn messages(&mut self, ui: &mut Ui, now: f64, picture: Rect) {
        self.messages.retain(|message| message.until > now);
        if self.messages.is_empty() {
            return;
        }
        let above = match self.problems.text.is_empty() {
            true => 0.0,
            false => self.problems.height,
        };
        let corner = picture.left_bottom() + vec2(12.0, -12.0 - above);
        Area::new(Id::unique("messages"))
            .fixed_pos(corner)
            .pivot(Align2::LEFT_BOTTOM)
            .show(ui.ctx(), |ui| {
                // An area is as wide as what it had last, where nothing says otherwise.
                ui.set_max_width((picture.width() - 24.0).max(100.0));
                for message in &self.messages {
                    Frame::popup(ui.style()).show(ui, |ui| {
                        let text = RichText::new(&message.text);
                        ui.label(match message.is_error {
                            true => text.color(ui.visuals().error_fg_color),
                            false => text,
                        });
                    });
                }
            });
        ui.ctx().request_repaint_after(Duration::from_millis(500));
    }
}
