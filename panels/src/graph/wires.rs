//! Links between cards: drawn, and connected where one is let go.

use egui::epaint::CubicBezierShape;
use egui::{Color32, Pos2, Rect, Shape, Stroke, Ui, vec2};

use super::{GraphView, OutputSocket, Sockets, pointer};
use crate::context::Context;
use crate::edits;
use crate::model::{Model, Target};

/// Points around a socket in which a link can be dropped.
const REACH: f32 = 16.0;

/// How far a link goes on sideways before it bends, at most.
const BEND: f32 = 160.0;

impl GraphView {
    /// The links that there are, and the one on the pointer.
    pub(super) fn links(&self, ui: &Ui, model: &Model, sockets: &Sockets) -> Vec<Shape> {
        let color = ui.visuals().widgets.inactive.fg_stroke.color;
        let mut shapes = Vec::new();
        for (material, end) in &sockets.sides {
            if let Some(&start) = sockets.surfaces.get(material) {
                shapes.push(curve(
                    start,
                    *end,
                    Stroke::new(1.0, color.gamma_multiply(0.5)),
                ));
            }
        }
        for wire in &model.wires {
            let source = OutputSocket {
                node: wire.source.clone(),
                swizzle: wire.swizzle,
            };
            let start = sockets.output(&source);
            let end = sockets.inputs.get(&wire.target);
            let is_off = (self.loose.as_ref())
                .is_some_and(|loose| loose.former.as_ref() == Some(&wire.target));
            if let (Some(&start), Some(&end), false) = (start, end, is_off)
                && ui.is_rect_visible(Rect::from_two_pos(start, end).expand2(vec2(BEND, 0.0)))
            {
                shapes.push(curve(start, end, Stroke::new(2.0, color)));
                let is_several = !sockets.outputs.contains_key(&source);
                if let (Some(swizzle), true) = (wire.swizzle, is_several) {
                    shapes.push(note(ui, start.lerp(end, 0.5), &swizzle.to_string()));
                }
            }
        }
        if let Some(loose) = &self.loose
            && let Some(&start) = sockets.output(&loose.source)
            && let Some(end) = pointer(ui)
        {
            let color = ui.visuals().selection.bg_fill;
            shapes.push(curve(start, end, Stroke::new(2.0, color)));
        }
        shapes
    }

    /// Connects the link on the pointer where it was let go, or says why not.
    pub(super) fn drop_loose(&mut self, ui: &Ui, cx: &mut Context<'_>, sockets: &Sockets) {
        let Some(loose) = &self.loose else {
            return;
        };
        let near = pointer(ui).and_then(|pointer| {
            let distance = |place: &Pos2| place.distance(pointer);
            let inputs = sockets.inputs.iter();
            let near = inputs.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)))?;
            (distance(near.1) < REACH).then(|| near.0.as_ref().clone())
        });
        let OutputSocket { node, swizzle } = &loose.source;
        // The socket that it hangs on may be out of sight by now, and not tell that it was let go.
        let is_dropped = sockets.is_dropped || ui.input(|input| !input.pointer.any_down());
        if !is_dropped {
            if let Some(target) = &near
                && let Err(why) = cx.model.check(node, *swizzle, target)
            {
                let error = egui::RichText::new(why).color(ui.visuals().error_fg_color);
                egui::Tooltip::always_open(
                    ui.ctx().clone(),
                    ui.layer_id(),
                    ui.scope_id().with("refused"),
                    egui::PopupAnchor::Pointer,
                )
                .show(|ui| ui.label(error));
            }
            return;
        }
        let taken_off = |target: &Target| edits::disconnect(cx.document, target);
        match (near, &loose.former) {
            (Some(target), former) if former.as_ref() != Some(&target) => {
                let connected = edits::connect(cx.model, node, *swizzle, &target).map(|edits| {
                    let off = former.as_ref().map(taken_off).unwrap_or_default();
                    off.into_iter().chain(edits).collect()
                });
                cx.edit_if(&format!("connect {node}"), connected);
            }
            (None, Some(former)) => {
                let edits = taken_off(former);
                cx.edit(&format!("disconnect {node}"), edits, None);
            }
            _ => {}
        }
        self.loose = None;
    }
}

fn curve(start: Pos2, end: Pos2, stroke: Stroke) -> Shape {
    let reach = vec2((0.5 * (end.x - start.x).abs()).clamp(24.0, BEND), 0.0);
    let points = [start, start + reach, end - reach, end];
    CubicBezierShape::from_points_stroke(points, false, Color32::TRANSPARENT, stroke).into()
}

/// A few letters at the middle of a link.
fn note(ui: &Ui, at: Pos2, text: &str) -> Shape {
    let font = egui::FontId::proportional(11.0);
    let color = ui.visuals().strong_text_color();
    let line = (ui.painter()).layout_no_wrap(text.to_owned(), font, color);
    let place = egui::Align2::CENTER_CENTER.anchor_size(at, line.size());
    let back = Shape::rect_filled(place.expand(2.0), 2.0, ui.visuals().extreme_bg_color);
    Shape::Vec(vec![back, Shape::galley(place.min, line, color)])
}
