//! What divides the picture: the border between pictures that are compared, and the region that is rendered.

use egui::{PointerButton, Pos2, Rect, Ui, Vec2};

use crate::link::Command;

use super::Viewer;
use super::borders::{Borders, Way};
use super::viewport::{corners, place};

/// Points around the border between both pictures in which it can be taken.
const GRIP: f32 = 6.0;
/// Borders of the region, in the order of its corners.
const REGION: [(&str, Way); 4] = [
    ("Left border of the region", Way::Across),
    ("Upper border of the region", Way::Along),
    ("Right border of the region", Way::Across),
    ("Lower border of the region", Way::Along),
];
/// Of the picture, that a region is wide and high where keys make it small.
const LEAST_REGION: f32 = 0.02;

impl Viewer {
    /// The border between both pictures. True while it has the pointer.
    pub(super) fn split_pointer(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) -> bool {
        let Some(split) = self.viewport.split else {
            self.viewport.is_splitting = false;
            return false;
        };
        let border = egui::lerp(rect.x_range(), split);
        let is_near = |at: Pos2| (at.x - border).abs() <= GRIP;
        if response.drag_started_by(PointerButton::Primary) {
            let start = ui.input(|input| input.pointer.press_origin());
            self.viewport.is_splitting = start.is_some_and(is_near);
        }
        let is_taken = self.viewport.is_splitting && response.dragged();
        if response.drag_stopped() {
            self.viewport.is_splitting = false;
        }
        if let Some(at) = response.interact_pointer_pos().filter(|_| is_taken) {
            self.viewport.split = Some(place(rect, at)[0]);
        }
        if is_taken || response.hover_pos().is_some_and(is_near) {
            ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
        }
        is_taken
    }

    /// Moves what lies between pictures, and what is around the region, as the keys say.
    pub(super) fn borders_by_keys(&mut self, ui: &Ui, rect: Rect) {
        if let Some(split) = self.viewport.split {
            let line = corners(rect, [split, 0.0, split, 1.0]).expand2(Vec2::new(GRIP, 0.0));
            let (name, within) = ("Border of Compare", (split, 0.0..=1.0));
            let moved = self
                .borders
                .line(ui, name, Way::Across, (rect, line), within);
            self.viewport.split = moved.or(self.viewport.split);
        }
        let Some(mut region) = self.viewport.region else {
            return;
        };
        // While it is drawn, it is the pointer's.
        if self.viewport.region_start.is_some() {
            return;
        }
        let mut has_moved = false;
        for (side, (name, way)) in REGION.into_iter().enumerate() {
            let mut line = region;
            line[(side + 2) % 4] = region[side];
            let line = corners(rect, line).expand(0.5 * GRIP);
            // A region has an extent.
            let range = match side {
                0 | 1 => 0.0..=region[side + 2] - LEAST_REGION,
                _ => region[side - 2] + LEAST_REGION..=1.0,
            };
            let within = (region[side], range);
            if let Some(to) = self.borders.line(ui, name, way, (rect, line), within) {
                region[side] = to;
                has_moved = true;
            }
        }
        if has_moved {
            self.viewport.region = Some(region);
            self.link.send(Command::Region(self.viewport.region));
        }
    }

    /// No region is to be chosen any more. One that was being drawn is none: the render doesn't know of it.
    pub(super) fn stop_choosing_region(&mut self) {
        self.viewport.chooses_region = false;
        if self.viewport.region_start.take().is_some() {
            self.viewport.region = None;
        }
    }

    pub(super) fn choose_region(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) {
        ui.ctx().set_cursor_icon(egui::CursorIcon::Crosshair);
        // By Enter it is in the middle, and its borders are moved from there.
        if response.clicked() && response.interact_pointer_pos().is_none() {
            self.viewport.region = Some([0.25, 0.25, 0.75, 0.75]);
            self.viewport.chooses_region = false;
            self.link.send(Command::Region(self.viewport.region));
            Borders::focus(ui, REGION[0].0);
            return;
        }
        if response.drag_started() {
            self.viewport.region_start = ui.input(|input| input.pointer.press_origin());
        }
        let Some(start) = self.viewport.region_start else {
            return;
        };
        if let Some(at) = response.interact_pointer_pos() {
            let ([x0, y0], [x1, y1]) = (place(rect, start), place(rect, at));
            let corners = [x0.min(x1), y0.min(y1), x0.max(x1), y0.max(y1)];
            self.viewport.region = Some(corners);
        }
        if response.drag_stopped() {
            self.viewport.region_start = None;
            self.viewport.chooses_region = false;
            self.link.send(Command::Region(self.viewport.region));
        }
    }
}
