//! Textures of the library that are dropped on the graph: on an input they drive it, beside all cards they are new nodes.

use egui::{DragAndDrop, Rect, Stroke, StrokeKind, Ui, vec2};

use super::rows::{ROW, WIDTH};
use super::{GraphItem, GraphView, pointer};
use crate::context::Context;
use crate::edits;
use crate::library::DraggedTexture;

impl GraphView {
    /// Shows what a texture that is dragged would drive, and does so when it is let go.
    pub(super) fn drop_texture(
        &mut self,
        ui: &Ui,
        cx: &mut Context<'_>,
        subjects: &[GraphItem<'_>],
    ) {
        if !DragAndDrop::has_payload_of_type::<DraggedTexture>(ui.ctx()) {
            return;
        }
        let in_window = ui.input(|input| input.pointer.latest_pos());
        let is_here = in_window.is_some_and(|at| {
            let top = ui.ctx().layer_id_at(at);
            self.area.contains(at) && top.is_none_or(|top| Some(top) == self.outer_layer)
        });
        let Some(at) = pointer(ui).filter(|_| is_here) else {
            return;
        };
        let mut under = None;
        for &subject in subjects {
            let rows = self.rows(cx, subject);
            let Some(&place) = self.places.get(&subject.id()) else {
                continue;
            };
            let card = Rect::from_min_size(place, vec2(WIDTH, rows.height));
            for (i, input) in rows.inputs.iter().enumerate() {
                let start = rows.input_place(card, i);
                let row = Rect::from_min_size(start - vec2(0.0, 0.5 * ROW), vec2(WIDTH, ROW));
                if row.expand2(vec2(0.5 * ROW, 0.0)).contains(at) {
                    under = Some((input.target.as_ref().clone(), row, card));
                }
            }
        }
        if let Some((_, row, _)) = &under {
            let stroke = Stroke::new(2.0, ui.visuals().selection.bg_fill);
            let painter = ui.painter();
            painter.rect_stroke(*row, 2.0, stroke, StrokeKind::Inside);
        }
        if !ui.input(|input| input.pointer.any_released()) {
            return;
        }
        let Some(texture) = DragAndDrop::take_payload::<DraggedTexture>(ui.ctx()) else {
            return;
        };
        match under {
            Some((target, ..)) => {
                if let Some(node) = cx.add_linked(&texture.0, &target) {
                    self.selected = [node].into();
                }
            }
            None => {
                let (node, edits) = edits::add_node(cx.document, &texture.0);
                self.places.insert(GraphItem::Node(&node).id(), at);
                cx.edit(&format!("add {node}"), edits, None);
                self.selected = [node].into();
            }
        }
    }
}
