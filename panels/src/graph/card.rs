//! One card of the graph: a node with its parameters, or a material with what can drive it.

use egui::accesskit::Role;
use egui::text::LayoutJob;
use egui::{
    Align2, Color32, FontId, Pos2, Rect, Response, Sense, Stroke, StrokeKind, Ui, Vec2, pos2, vec2,
};

use super::rows::{Input, MARGIN, PREVIEW, ROW, Rows, Shown, TITLE, WIDTH};
use super::{GraphItem, GraphView, Loose, OutputSocket, Sockets};
use crate::context::Context;
use crate::pictures::take_material;
use crate::widgets::{context_menu, describe, menu};
use crate::{framing, links, node};

const SOCKET: f32 = 5.0;

/// Below this zoom nothing written on a card can be read, and no socket be hit: cards are mere shapes.
const READABLE: f32 = 0.3;

impl GraphView {
    /// Shows a card, and notes where its sockets are.
    pub(super) fn card(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        subject: GraphItem<'_>,
        sockets: &mut Sockets,
    ) {
        let id = subject.id();
        let place = *self.places.entry(id.clone()).or_default();
        let rows = self.rows(cx, subject);
        let card = Rect::from_min_size(place, vec2(WIDTH, rows.height));
        // Sockets stand out at the sides.
        ui.expand_to_include_rect(card.expand(3.0 * SOCKET));
        rows.put_sockets(card, subject, sockets);
        if !ui.is_rect_visible(card.expand(3.0 * SOCKET)) {
            return;
        }
        let body = ui.interact(card, ui.scope_id().with(&id), Sense::click_and_drag());
        describe(&body, Role::Button, &id);
        self.handle(ui, cx, subject, &body);
        if let GraphItem::Material(material) = subject {
            take_material(ui, cx, material, &body);
        }
        let (name, is_selected) = match subject {
            GraphItem::Node(name) => (name, self.selected.contains(name)),
            GraphItem::Material(name) => (name, false),
        };
        paint_body(ui, card, subject, is_selected);
        if zoom(ui) < READABLE {
            return;
        }
        let title = pos2(card.left() + 2.0 * MARGIN, card.top() + 0.5 * TITLE);
        let color = ui.visuals().strong_text_color();
        let room = WIDTH - 4.0 * MARGIN;
        write(ui, title, Align2::LEFT_CENTER, name, room, color);
        match subject {
            GraphItem::Node(node) => {
                self.outputs(ui, &rows, card, sockets);
                let corner = pos2(card.left() + 2.0 * MARGIN, card.top() + TITLE);
                let place = Rect::from_min_size(corner, vec2(PREVIEW, PREVIEW));
                cx.paint_preview(ui, node, place);
            }
            GraphItem::Material(material) => sides(ui, cx, material, card),
        }
        for (i, row) in rows.inputs.iter().enumerate() {
            self.input(ui, cx, rows.input_place(card, i), row, sockets);
        }
    }

    /// Moves and selects.
    fn handle(&mut self, ui: &Ui, cx: &mut Context<'_>, subject: GraphItem<'_>, body: &Response) {
        if let GraphItem::Node(node) = subject {
            if body.clicked() || body.drag_started() {
                let is_added = ui.input(|input| input.modifiers.shift || input.modifiers.command);
                let is_in = self.selected.contains(node);
                if is_added && is_in && body.clicked() {
                    self.selected.remove(node);
                } else {
                    // What is selected is dragged as a whole.
                    let is_moved = is_in && body.drag_started();
                    if !(is_added || is_moved) {
                        self.selected.clear();
                    }
                    self.selected.insert(node.to_owned());
                }
            }
            context_menu(body, |ui| {
                menu(ui, "Rename", |ui| {
                    if node::rename_field(ui, cx, node) {
                        ui.close();
                    }
                });
                type Deed = fn(&mut GraphView, &mut Context<'_>);
                let deeds: [(&str, Deed); 3] = [
                    ("Duplicate", Self::duplicate),
                    ("Frame", Self::frame_selected),
                    ("Delete", Self::delete),
                ];
                for (text, deed) in deeds {
                    if !ui.button(text).clicked() {
                        continue;
                    }
                    if !self.selected.contains(node) {
                        self.selected = [node.to_owned()].into();
                    }
                    deed(self, cx);
                    ui.close();
                }
                if framing::frame_of(cx.document, node).is_some()
                    && ui.button("Take out of the frame").clicked()
                {
                    let edits = framing::unframe(cx.document, &[node.to_owned()], &[]);
                    cx.edit(&format!("take {node} out of its frame"), edits, None);
                    ui.close();
                }
            });
        }
        if let GraphItem::Material(material) = subject {
            context_menu(body, |ui| super::frames::material_menu(ui, cx, material));
        }
        let by_key = self.card_keys(ui, cx, subject, body);
        if body.dragged() || by_key != Vec2::ZERO {
            let moved = body.drag_delta() + by_key;
            let ids: Vec<String> = match subject {
                GraphItem::Node(node) if self.selected.contains(node) => self
                    .selected
                    .iter()
                    .map(|n| GraphItem::Node(n).id())
                    .collect(),
                // The keyboard may be on another card than those that are selected.
                GraphItem::Node(_) | GraphItem::Material(_) => vec![subject.id()],
            };
            for id in ids {
                *self.places.entry(id).or_default() += moved;
            }
        }
    }

    /// The sockets on the right: the whole result, and each of its components.
    fn outputs(&mut self, ui: &mut Ui, rows: &Rows, card: Rect, sockets: &mut Sockets) {
        if rows.outputs.is_empty() {
            let place = pos2(
                card.left() + 3.0 * MARGIN + PREVIEW,
                card.top() + TITLE + ROW,
            );
            let color = ui.visuals().error_fg_color;
            let room = WIDTH - PREVIEW;
            write(ui, place, Align2::LEFT_CENTER, "no texture", room, color);
        }
        for (i, output) in rows.outputs.iter().enumerate() {
            let center = Rows::output_place(card, i);
            let swizzle = output.source.swizzle;
            let component = swizzle.map_or(String::new(), |s| s.to_string());
            let text = center - vec2(2.0 * MARGIN, 0.0);
            let color = ui.visuals().weak_text_color();
            let letter = component.trim_start_matches('.');
            write(
                ui,
                text,
                Align2::RIGHT_CENTER,
                letter,
                WIDTH - PREVIEW - 4.0 * MARGIN,
                color,
            );
            let label = format!("Output {}{component}", output.source.node);
            let socket = socket(ui, center, &label, output.color);
            if socket.drag_started() {
                self.loose = Some(Loose {
                    source: output.source.as_ref().clone(),
                    former: None,
                });
            }
            sockets.is_dropped |= socket.drag_stopped();
        }
    }

    fn input(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        center: Pos2,
        row: &Input,
        sockets: &mut Sockets,
    ) {
        let target = row.target.as_ref();
        let full = links::target_name(target, &row.label);
        let text = center + vec2(2.0 * MARGIN, 0.0);
        let taken = constant(ui, center, row.value.as_ref());
        let (ink, room) = (ui.visuals().text_color(), WIDTH - 3.0 * MARGIN - taken);
        write(ui, text, Align2::LEFT_CENTER, &row.label, room, ink);
        let socket = socket(ui, center, &format!("Input {full}"), row.color);
        let wire = cx.model.source(target).cloned();
        if let (true, Some(wire)) = (socket.drag_started(), &wire) {
            self.loose = Some(Loose {
                source: OutputSocket {
                    node: wire.source.clone(),
                    swizzle: wire.swizzle,
                },
                former: Some(target.clone()),
            });
        }
        sockets.is_dropped |= socket.drag_stopped();
        context_menu(&socket, |ui| {
            links::link_menu(ui, cx, target, &full, wire.is_some(), "Disconnect");
        });
    }
}

/// Paints a constant at the right end of its row. Gives the points that it takes.
fn constant(ui: &Ui, start: Pos2, value: Option<&Shown>) -> f32 {
    let end = start + vec2(WIDTH - MARGIN, 0.0);
    match value {
        None => 0.0,
        Some(Shown::Color([r, g, b])) => {
            let color = egui::Rgba::from_rgb(*r, *g, *b);
            let place = Rect::from_center_size(end - vec2(12.0, 0.0), vec2(24.0, ROW - 6.0));
            let edge = Stroke::new(1.0, ui.visuals().weak_text_color());
            let painter = ui.painter();
            painter.rect(place, 2.0, color, edge, StrokeKind::Inside);
            30.0
        }
        Some(Shown::Text(text)) => {
            let (color, room) = (ui.visuals().weak_text_color(), 0.5 * WIDTH);
            write(ui, end, Align2::RIGHT_CENTER, text, room, color) + MARGIN
        }
    }
}

/// Points on the screen for one of the plane.
fn zoom(ui: &Ui) -> f32 {
    let to_screen = ui.ctx().layer_transform_to_global(ui.layer_id());
    to_screen.map_or(1.0, |to_screen| to_screen.scaling)
}

fn paint_body(ui: &Ui, card: Rect, subject: GraphItem<'_>, is_selected: bool) {
    let visuals = ui.visuals();
    let stroke = match is_selected {
        true => Stroke::new(2.0, visuals.selection.bg_fill),
        false => visuals.widgets.noninteractive.bg_stroke,
    };
    let title = card.with_max_y(card.top() + TITLE);
    let head = match subject {
        GraphItem::Node(_) => visuals.widgets.inactive.bg_fill,
        GraphItem::Material(_) => visuals.selection.bg_fill.gamma_multiply(0.6),
    };
    let painter = ui.painter();
    painter.rect_filled(card, 4.0, visuals.window_fill);
    painter.rect_filled(title, 4.0, head);
    painter.rect_stroke(card, 4.0, stroke, StrokeKind::Outside);
}

/// The rows of a blend's two sides.
fn sides(ui: &Ui, cx: &Context<'_>, material: &str, card: Rect) {
    for (i, name) in cx.model.sides(material).into_iter().flatten().enumerate() {
        let side = ["Base", "Over"][i];
        let text = match name == material {
            true => format!("{side}: itself"),
            false => format!("{side}: {name}"),
        };
        let color = ui.visuals().weak_text_color();
        let start = Rows::side_place(card, i) + vec2(2.0 * MARGIN, 0.0);
        let room = WIDTH - 3.0 * MARGIN;
        write(ui, start, Align2::LEFT_CENTER, &text, room, color);
    }
}

fn socket(ui: &mut Ui, center: Pos2, label: &str, color: Color32) -> Response {
    let place = Rect::from_center_size(center, vec2(3.0 * SOCKET, 3.0 * SOCKET));
    let id = ui.scope_id().with(label);
    let response = ui.interact(place, id, Sense::click_and_drag());
    describe(&response, Role::Button, label);
    let radius = match response.hovered() || response.dragged() {
        true => SOCKET + 1.5,
        false => SOCKET,
    };
    let stroke = Stroke::new(1.0, ui.visuals().window_fill);
    ui.painter().circle(center, radius, color, stroke);
    response.on_hover_text(label)
}

/// One line of text, cut where there is no more room. Gives its width.
fn write(ui: &Ui, at: Pos2, anchor: Align2, text: &str, width: f32, color: Color32) -> f32 {
    let mut job = LayoutJob::simple_singleline(text.to_owned(), FontId::proportional(12.0), color);
    job.wrap = egui::text::TextWrapping::truncate_at_width(width);
    let line = ui.painter().layout_job(job);
    let place = anchor.anchor_size(at, line.size());
    let width = line.size().x;
    ui.painter().galley(place.min, line, color);
    width
}
