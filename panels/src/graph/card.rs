//! One card of the graph: a node with its parameters, or a material with what can drive it.

use egui::accesskit::Role;
use egui::text::LayoutJob;
use egui::{
    Align2, Color32, FontId, Pos2, Rect, Response, Sense, Stroke, StrokeKind, Ui, pos2, vec2,
};
use engine::procedural::{Kind, Output};
use texgen::{OutputType, ParameterType, Swizzle};

use super::{GraphView, Loose, Sockets, Source, Subject};
use crate::context::Context;
use crate::material::KEYS;
use crate::model::Target;
use crate::widgets::{context_menu, describe, menu};
use crate::{links, list};

const WIDTH: f32 = 190.0;
const TITLE: f32 = 24.0;
const ROW: f32 = 18.0;
const PREVIEW: f32 = 64.0;
const MARGIN: f32 = 6.0;
const SOCKET: f32 = 5.0;

/// What of a node or material can be driven, with its label and colour.
fn inputs(cx: &Context<'_>, subject: Subject<'_>) -> Vec<(Target, String, Color32)> {
    match subject {
        Subject::Node(node) => {
            let parameters = cx.model.texture(node).map_or(&[][..], |t| t.parameters());
            let linkable = parameters.iter().filter(|p| p.ty.is_linkable());
            let input = linkable.map(|parameter| {
                let target = Target::Parameter {
                    node: node.to_owned(),
                    parameter: parameter.name.clone(),
                };
                let label = list::short_label(parameter).to_owned();
                (target, label, color_of(components(parameter.ty)))
            });
            input.collect()
        }
        Subject::Material(material) => {
            let mask = cx.model.sides(material).map(|_| {
                let target = Target::Mask {
                    material: material.to_owned(),
                };
                (target, "Mask".to_owned(), color_of(1))
            });
            let keys = KEYS.iter().filter_map(|key| {
                let output = key.output()?;
                let target = Target::Input {
                    material: material.to_owned(),
                    output,
                };
                let is_driven = cx.model.source(&target).is_some();
                let is_usual = key.is_common && output != Output::EmissionStrength;
                let is_shown = is_driven || (is_usual && !cx.model.is_pure_blend(material));
                let count = match output.kind() {
                    Kind::Scalar => 1,
                    Kind::Color | Kind::Vector => 3,
                };
                is_shown.then(|| (target, key.label.to_owned(), color_of(count)))
            });
            mask.into_iter().chain(keys).collect()
        }
    }
}

fn components(ty: ParameterType) -> usize {
    match ty {
        ParameterType::Vec2 => 2,
        ParameterType::Vec3 => 3,
        ParameterType::Vec4 => 4,
        _ => 1,
    }
}

/// Of a socket that takes or gives so many numbers.
fn color_of(components: usize) -> Color32 {
    match components {
        1 => Color32::from_rgb(160, 160, 160),
        2 => Color32::from_rgb(90, 170, 120),
        3 => Color32::from_rgb(210, 180, 80),
        _ => Color32::from_rgb(170, 110, 200),
    }
}

/// Points that a card is high.
pub(super) fn height(cx: &Context<'_>, subject: Subject<'_>) -> f32 {
    let rows = inputs(cx, subject).len() as f32;
    let head = match subject {
        Subject::Node(_) => PREVIEW + MARGIN,
        // The sides of a blend.
        Subject::Material(material) => cx.model.sides(material).map_or(0.0, |_| 2.0 * ROW),
    };
    TITLE + head + rows * ROW + MARGIN
}

impl GraphView {
    /// Shows a card, and notes where its sockets are.
    pub(super) fn card(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        subject: Subject<'_>,
        sockets: &mut Sockets,
    ) {
        let id = subject.id();
        let place = *self.places.entry(id.clone()).or_default();
        let card = Rect::from_min_size(place, vec2(WIDTH, height(cx, subject)));
        // Sockets stand out at the sides.
        ui.expand_to_include_rect(card.expand(3.0 * SOCKET));
        let body = ui.interact(card, ui.scope_id().with(&id), Sense::click_and_drag());
        describe(&body, Role::Button, &id);
        self.handle(ui, cx, subject, &body);
        let (name, is_selected) = match subject {
            Subject::Node(name) => (name, self.selected.contains(name)),
            Subject::Material(name) => (name, false),
        };
        paint_body(ui, card, subject, is_selected);
        let title = pos2(card.left() + 2.0 * MARGIN, card.top() + 0.5 * TITLE);
        let color = ui.visuals().strong_text_color();
        write(
            ui,
            title,
            Align2::LEFT_CENTER,
            name,
            WIDTH - 4.0 * MARGIN,
            color,
        );
        let top = match subject {
            Subject::Node(node) => {
                self.outputs(ui, cx, node, card, sockets);
                let corner = pos2(card.left() + 2.0 * MARGIN, card.top() + TITLE);
                let place = Rect::from_min_size(corner, vec2(PREVIEW, PREVIEW));
                cx.paint_preview(ui, node, place);
                card.top() + TITLE + PREVIEW + MARGIN
            }
            Subject::Material(material) => {
                let surface = pos2(card.right(), title.y);
                sockets.surfaces.insert(material.to_owned(), surface);
                sides(ui, cx, material, card, sockets)
            }
        };
        for (i, (target, label, color)) in inputs(cx, subject).into_iter().enumerate() {
            let center = pos2(card.left(), top + (i as f32 + 0.5) * ROW);
            self.input(ui, cx, center, target, &label, color, sockets);
        }
    }

    /// Moves and selects.
    fn handle(&mut self, ui: &Ui, cx: &mut Context<'_>, subject: Subject<'_>, body: &Response) {
        if let Subject::Node(node) = subject {
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
                    if list::rename_field(ui, cx, node) {
                        ui.close();
                    }
                });
                for (text, is_delete) in [("Duplicate", false), ("Delete", true)] {
                    if !ui.button(text).clicked() {
                        continue;
                    }
                    if !self.selected.contains(node) {
                        self.selected = [node.to_owned()].into();
                    }
                    match is_delete {
                        true => self.delete(cx),
                        false => self.duplicate(cx),
                    }
                    ui.close();
                }
            });
        }
        if body.dragged() {
            let moved = body.drag_delta();
            let ids: Vec<String> = match subject {
                Subject::Node(_) => self
                    .selected
                    .iter()
                    .map(|n| Subject::Node(n).id())
                    .collect(),
                Subject::Material(_) => vec![subject.id()],
            };
            for id in ids {
                *self.places.entry(id).or_default() += moved;
            }
        }
    }

    /// The sockets on the right: the whole result, and each of its components.
    fn outputs(
        &mut self,
        ui: &mut Ui,
        cx: &Context<'_>,
        node: &str,
        card: Rect,
        sockets: &mut Sockets,
    ) {
        let Some(output) = cx.model.texture(node).map(|texture| texture.output()) else {
            let place = pos2(
                card.left() + 3.0 * MARGIN + PREVIEW,
                card.top() + TITLE + ROW,
            );
            let color = ui.visuals().error_fg_color;
            write(
                ui,
                place,
                Align2::LEFT_CENTER,
                "no texture",
                WIDTH - PREVIEW,
                color,
            );
            return;
        };
        let count = output.components();
        let whole = pos2(card.right(), card.top() + 0.5 * TITLE);
        self.output(ui, node, None, whole, color_of(count), sockets);
        if output == OutputType::F32 {
            return;
        }
        for (i, component) in ["x", "y", "z", "w"].into_iter().take(count).enumerate() {
            let center = pos2(card.right(), card.top() + TITLE + (i as f32 + 0.5) * 15.0);
            let text = center - vec2(2.0 * MARGIN, 0.0);
            let color = ui.visuals().weak_text_color();
            write(ui, text, Align2::RIGHT_CENTER, component, ROW, color);
            self.output(
                ui,
                node,
                component.parse().ok(),
                center,
                color_of(1),
                sockets,
            );
        }
    }

    fn output(
        &mut self,
        ui: &mut Ui,
        node: &str,
        swizzle: Option<Swizzle>,
        center: Pos2,
        color: Color32,
        sockets: &mut Sockets,
    ) {
        let source = Source {
            node: node.to_owned(),
            swizzle,
        };
        let label = match swizzle {
            Some(swizzle) => format!("Output {node}{swizzle}"),
            None => format!("Output {node}"),
        };
        let socket = socket(ui, center, &label, color);
        if socket.drag_started() {
            self.loose = Some(Loose {
                source: source.clone(),
                former: None,
            });
        }
        sockets.is_dropped |= socket.drag_stopped();
        sockets.outputs.insert(source, center);
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "what a row of a card consists of"
    )]
    fn input(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        center: Pos2,
        target: Target,
        label: &str,
        color: Color32,
        sockets: &mut Sockets,
    ) {
        let full = links::target_name(&target, label);
        let text = center + vec2(2.0 * MARGIN, 0.0);
        let ink = ui.visuals().text_color();
        write(
            ui,
            text,
            Align2::LEFT_CENTER,
            label,
            WIDTH - 3.0 * MARGIN,
            ink,
        );
        let socket = socket(ui, center, &format!("Input {full}"), color);
        let wire = cx.model.source(&target).cloned();
        if let (true, Some(wire)) = (socket.drag_started(), &wire) {
            self.loose = Some(Loose {
                source: Source {
                    node: wire.source.clone(),
                    swizzle: wire.swizzle,
                },
                former: Some(target.clone()),
            });
        }
        sockets.is_dropped |= socket.drag_stopped();
        context_menu(&socket, |ui| {
            links::link_menu(ui, cx, &target, &full, wire.is_some(), "Disconnect");
        });
        sockets.inputs.insert(target, center);
    }
}

fn paint_body(ui: &Ui, card: Rect, subject: Subject<'_>, is_selected: bool) {
    let visuals = ui.visuals();
    let stroke = match is_selected {
        true => Stroke::new(2.0, visuals.selection.bg_fill),
        false => visuals.widgets.noninteractive.bg_stroke,
    };
    let title = card.with_max_y(card.top() + TITLE);
    let head = match subject {
        Subject::Node(_) => visuals.widgets.inactive.bg_fill,
        Subject::Material(_) => visuals.selection.bg_fill.gamma_multiply(0.6),
    };
    let painter = ui.painter();
    painter.rect_filled(card, 4.0, visuals.window_fill);
    painter.rect_filled(title, 4.0, head);
    painter.rect_stroke(card, 4.0, stroke, StrokeKind::Outside);
}

/// The rows of a blend's two sides; gives where the next row begins.
fn sides(ui: &Ui, cx: &Context<'_>, material: &str, card: Rect, sockets: &mut Sockets) -> f32 {
    let top = card.top() + TITLE;
    let Some(names) = cx.model.sides(material) else {
        return top;
    };
    for (i, (side, name)) in ["Base", "Over"].into_iter().zip(names).enumerate() {
        let place = pos2(card.left(), top + (i as f32 + 0.5) * ROW);
        let itself = name == material;
        let text = match itself {
            true => format!("{side}: itself"),
            false => format!("{side}: {name}"),
        };
        let color = ui.visuals().weak_text_color();
        let start = place + vec2(2.0 * MARGIN, 0.0);
        write(
            ui,
            start,
            Align2::LEFT_CENTER,
            &text,
            WIDTH - 3.0 * MARGIN,
            color,
        );
        if !itself {
            sockets.sides.push((name.to_owned(), place));
        }
    }
    top + 2.0 * ROW
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

/// One line of text, cut where there is no more room.
fn write(ui: &Ui, at: Pos2, anchor: Align2, text: &str, width: f32, color: Color32) {
    let mut job = LayoutJob::simple_singleline(text.to_owned(), FontId::proportional(12.0), color);
    job.wrap = egui::text::TextWrapping::truncate_at_width(width);
    let line = ui.painter().layout_job(job);
    let place = anchor.anchor_size(at, line.size());
    ui.painter().galley(place.min, line, color);
}
