//! What is selected, found and copied on a graph.

use egui::{
    Event, Key, Modifiers, PointerButton, Pos2, Rect, Response, Stroke, StrokeKind, Ui, vec2,
};

use super::rows::WIDTH;
use super::{GraphItem, GraphView};
use crate::clipboard;
use crate::context::Context;
use crate::widgets::name;

impl GraphView {
    /// A rectangle that is drawn with Shift or Command held selects the nodes that it touches.
    pub(super) fn select_in_box(&mut self, ui: &Ui, cx: &Context<'_>, plane: &Response) {
        let held = ui.input(|input| input.modifiers.shift || input.modifiers.command);
        if plane.drag_started_by(PointerButton::Primary) && held {
            self.box_start = ui.input(|input| input.pointer.press_origin());
        }
        let Some(start) = self.box_start else {
            return;
        };
        let end = ui.input(|input| input.pointer.latest_pos());
        let drawn = Rect::from_two_pos(start, end.unwrap_or(start));
        let painter = ui.ctx().layer_painter(egui::LayerId::new(
            egui::Order::Foreground,
            egui::Id::unique("selection"),
        ));
        let stroke = Stroke::new(1.0, ui.visuals().selection.bg_fill);
        painter.rect_stroke(drawn, 0.0, stroke, StrokeKind::Inside);
        if !plane.drag_stopped() && ui.input(|input| input.pointer.any_down()) {
            return;
        }
        self.box_start = None;
        let area = self.on_plane(drawn);
        let nodes: Vec<String> = self.nodes_shown.clone();
        for node in nodes {
            let rows = self.rows(cx, GraphItem::Node(&node));
            let Some(&place) = self.places.get(&GraphItem::Node(&node).id()) else {
                continue;
            };
            let card = Rect::from_min_size(place, vec2(WIDTH, rows.height));
            if card.intersects(area) {
                self.selected.insert(node);
            }
        }
    }

    /// A rectangle of the window on the plane.
    fn on_plane(&self, drawn: Rect) -> Rect {
        let at = |p: Pos2| {
            let share = (p - self.area.min) / self.area.size();
            self.seen.min + share * self.seen.size()
        };
        Rect::from_two_pos(at(drawn.min), at(drawn.max))
    }

    /// Copies, cuts and pastes, unless a text is being written.
    pub(super) fn take_clipboard(&mut self, ui: &Ui, cx: &mut Context<'_>) {
        let events = ui.input(|input| input.events.clone());
        for event in events {
            match event {
                Event::Copy | Event::Cut if !self.selected.is_empty() => {
                    let nodes: Vec<String> = self.selected.iter().cloned().collect();
                    let copied = clipboard::copied(cx.document, &nodes);
                    ui.ctx().copy_text(copied.text);
                    if event == Event::Cut {
                        // What is nowhere else stays.
                        self.selected = copied.nodes.into_iter().collect();
                        self.delete(cx);
                    }
                    if let Some(why) = copied.refused {
                        cx.edit_if("copy", Err(why));
                    }
                }
                Event::Paste(text) => self.paste(cx, &text),
                _ => {}
            }
        }
        let all = ui.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::A));
        if all {
            self.selected = self.nodes_shown.iter().cloned().collect();
        }
    }

    fn paste(&mut self, cx: &mut Context<'_>, text: &str) {
        match clipboard::pasted(cx.document, cx.textures, text) {
            Ok((names, edits)) => {
                let corner = match self.seen.is_positive() {
                    true => self.seen.center(),
                    false => Pos2::ZERO,
                };
                for (number, name) in (0u8..).zip(&names) {
                    let place = corner + vec2(30.0, 30.0) * f32::from(number);
                    self.places.insert(GraphItem::Node(name).id(), place);
                }
                cx.edit(&format!("paste {}", names.join(", ")), edits, None);
                self.selected = names.into_iter().collect();
            }
            Err(why) => cx.edit_if("paste", Err(why)),
        }
    }

    /// A field that brings the node whose name or texture is written into view.
    pub(super) fn find(&mut self, ui: &mut Ui, cx: &Context<'_>) {
        let field = egui::TextEdit::singleline(&mut self.wanted)
            .hint_text("find")
            .desired_width(90.0);
        let field = ui.add(field);
        name(&field, "Find a node");
        if !field.changed() || self.wanted.is_empty() {
            return;
        }
        let wanted = self.wanted.to_lowercase();
        let texture = |node: &str| {
            let table = cx.model.table(cx.document.look(), node);
            table.map_or("", |table| &table.texture.value)
        };
        let has = |text: &str| text.to_lowercase().contains(&wanted);
        let nodes = &self.nodes_shown;
        let by_name = nodes.iter().find(|node| has(node));
        let found = by_name
            .or_else(|| nodes.iter().find(|node| has(texture(node))))
            .cloned();
        if let Some(node) = found {
            if let Some(&place) = self.places.get(&GraphItem::Node(&node).id()) {
                let size = self.seen.size();
                self.seen = Rect::from_center_size(place + vec2(0.5 * WIDTH, 60.0), size);
            }
            self.select(&node);
        }
    }
}
