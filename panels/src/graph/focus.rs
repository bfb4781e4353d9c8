//! The keyboard on the graph: from card to card, and cards that are moved by it.

use egui::{EventFilter, Key, Modifiers, Pos2, Rect, Response, Ui, Vec2, vec2};

use super::rows::WIDTH;
use super::{GraphItem, GraphView};
use crate::context::Context;

/// Points that a card moves by a key.
const STEP: f32 = 20.0;
const ARROWS: [(Key, Vec2); 4] = [
    (Key::ArrowLeft, Vec2::LEFT),
    (Key::ArrowRight, Vec2::RIGHT),
    (Key::ArrowUp, Vec2::UP),
    (Key::ArrowDown, Vec2::DOWN),
];

/// How far the keyboard moves what has it.
pub(super) fn moved(ui: &Ui, response: &Response) -> Vec2 {
    if !response.has_focus() {
        return Vec2::ZERO;
    }
    keep_arrows(ui, response);
    pressed(ui, Modifiers::SHIFT) * STEP
}

/// The arrows don't take the keyboard elsewhere.
fn keep_arrows(ui: &Ui, response: &Response) {
    let filter = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        ..EventFilter::default()
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
}

/// The sum of the arrows that were pressed.
fn pressed(ui: &Ui, modifiers: Modifiers) -> Vec2 {
    ARROWS.iter().fold(Vec2::ZERO, |sum, &(key, way)| {
        let count = ui.input_mut(|input| input.count_and_consume_key(modifiers, key));
        sum + way * count as f32
    })
}

impl GraphView {
    /// Arrows go to the next card, with Shift they move it, Enter shows its values.
    pub(super) fn card_keys(
        &mut self,
        ui: &Ui,
        cx: &mut Context<'_>,
        subject: GraphItem<'_>,
        body: &Response,
    ) -> Vec2 {
        if body.clicked() || body.drag_started() {
            body.request_focus();
        }
        if !body.has_focus() {
            return Vec2::ZERO;
        }
        let by_tab = ui.input(|input| input.key_pressed(Key::Tab));
        if by_tab && body.gained_focus() {
            self.revealed = Some(body.rect);
        }
        // The longer ones first: an arrow with Shift is an arrow, too.
        let moved = moved(ui, body);
        let way = pressed(ui, Modifiers::NONE);
        if way != Vec2::ZERO
            && let Some((id, rect)) = self.next_card(&subject.id(), body.rect.center(), way)
        {
            let id = ui.scope_id().with(&id);
            ui.memory_mut(|memory| memory.request_focus(id));
            self.revealed = Some(rect);
        }
        let is_opened = ui.input(|input| input.key_pressed(Key::Enter));
        if let (GraphItem::Node(node), true) = (subject, is_opened) {
            cx.show_node(node);
        }
        if moved != Vec2::ZERO {
            self.revealed = Some(body.rect.translate(moved));
        }
        moved
    }

    /// The card that lies next in a direction.
    fn next_card(&self, own: &str, from: Pos2, way: Vec2) -> Option<(String, Rect)> {
        let others = self.shown.iter().filter(|id| *id != own);
        let ahead = others.filter_map(|id| {
            let place = self.places.get(id)?;
            let height = self.rows.get(id).map_or(100.0, |rows| rows.height);
            let rect = Rect::from_min_size(*place, vec2(WIDTH, height));
            let to = rect.center() - from;
            let along = to.dot(way);
            // What lies aside is farther than what lies ahead.
            let aside = (to - way * along).length();
            (along > 1.0).then_some((along + 2.0 * aside, id, rect))
        });
        let (_, id, rect) = ahead.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((id.clone(), rect))
    }

    /// Brings what the keyboard has gone to into sight.
    pub(super) fn reveal(&mut self, ui: &Ui) {
        let Some(rect) = self.revealed.take() else {
            return;
        };
        if !self.seen.is_positive() || self.seen.contains_rect(rect) {
            return;
        }
        let rect = rect.expand(20.0);
        let nearer = |low: f32, high: f32, seen_low: f32, seen_high: f32| {
            if low < seen_low || high - low > seen_high - seen_low {
                low - seen_low
            } else {
                (high - seen_high).max(0.0)
            }
        };
        let seen = self.seen;
        let by = vec2(
            nearer(rect.left(), rect.right(), seen.left(), seen.right()),
            nearer(rect.top(), rect.bottom(), seen.top(), seen.bottom()),
        );
        self.seen = seen.translate(by);
        ui.ctx().request_repaint();
    }

    /// Whether keys are for the graph: the keyboard is there, or nowhere, and the pointer is there. Not where a question lies over it.
    pub(super) fn has_keyboard(&self, ui: &Ui) -> bool {
        let outer = ui.layer_id();
        if !ui.memory(|memory| memory.allows_interaction(outer)) {
            return false;
        }
        let focused = ui.memory(|memory| memory.focused());
        let response = focused.and_then(|id| ui.ctx().read_response(id));
        let layer = response.map(|response| response.layer_id);
        let is_own = layer.is_some() && layer == self.layer;
        let is_elsewhere = focused.is_some() && !is_own;
        let pointer = ui.input(|input| input.pointer.latest_pos());
        let is_here = pointer.is_none_or(|pointer| self.area.contains(pointer));
        is_own || is_here && !is_elsewhere
    }
}
