//! Frames around cards: rectangles with a title, which the look keeps.

use egui::accesskit::Role;
use egui::{Align2, Color32, FontId, Rect, Rgba, Sense, Stroke, StrokeKind, Ui, vec2};
use engine::scene::look::{FrameLook, Section, Value};
use engine::session::Edit;

use super::rows::WIDTH;
use super::{GraphItem, GraphView};
use crate::context::Context;
use crate::framing;
use crate::widgets::{context_menu, describe, draft, menu, name};

/// Points between the cards and their frame, and of its title above that.
const MARGIN: f32 = 14.0;
const HEAD: f32 = 24.0;
/// Of what lies below a frame, so much of it can be seen.
const TINT: f32 = 0.14;
/// Share of the frame's colour in what lies behind its title: letters can be read on all of them.
const HEAD_TINT: f32 = 0.35;

const COLORS: [(&str, &str); 6] = [
    ("Red", "#c8443a"),
    ("Orange", "#d08a2e"),
    ("Green", "#5a9a4a"),
    ("Blue", "#3a7ac8"),
    ("Violet", "#8a5ac0"),
    ("Grey", "#8a8a8a"),
];

/// The frame around some cards; none around nothing.
pub(super) fn around(cards: impl Iterator<Item = Rect>) -> Option<Rect> {
    let all = cards.reduce(|a, b| a.union(b))?.expand(MARGIN);
    Some(all.with_min_y(all.top() - HEAD))
}

impl GraphView {
    /// Shows all frames that have a card here. A title moves all of its cards.
    pub(super) fn frames(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let document = cx.document;
        for frame in &document.look().frames {
            let nodes: Vec<&str> = (frame.nodes.iter().map(|node| &*node.value))
                .filter(|node| self.nodes_shown.iter().any(|shown| shown == node))
                .collect();
            let materials = frame.materials.iter().map(|material| &*material.value);
            let materials = materials.map(GraphItem::Material);
            let materials = materials.filter(|material| self.shown.contains(&material.id()));
            let members = nodes.iter().map(|&node| GraphItem::Node(node));
            let members: Vec<GraphItem<'_>> = members.chain(materials).collect();
            let cards: Vec<Rect> = members
                .iter()
                .filter_map(|&member| {
                    let height = self.rows(cx, member).height;
                    let place = self.places.get(&member.id())?;
                    Some(Rect::from_min_size(*place, vec2(WIDTH, height)))
                })
                .collect();
            let Some(rect) = around(cards.into_iter()) else {
                continue;
            };
            ui.expand_to_include_rect(rect);
            let moved = show(ui, cx, frame, rect);
            if moved.is_chosen {
                self.selected = nodes.iter().map(|&node| node.to_owned()).collect();
            }
            if moved.by != egui::Vec2::ZERO {
                for member in members {
                    *self.places.entry(member.id()).or_default() += moved.by;
                }
            }
        }
    }

    /// Puts a frame around the nodes that are selected.
    pub(super) fn frame_selected(&mut self, cx: &mut Context<'_>) {
        let nodes: Vec<String> = self.selected.iter().cloned().collect();
        if !nodes.is_empty() {
            let (title, edits) = framing::frame(cx.document, &nodes);
            cx.edit(&format!("frame {title}"), edits, None);
        }
    }
}

/// Entries of the menu of a material's card: into a frame, and out of it.
pub(super) fn material_menu(ui: &mut Ui, cx: &mut Context<'_>, material: &str) {
    let document = cx.document;
    let own = framing::frame_of_material(document, material);
    let own = own.map(|frame| frame.name.value.as_str());
    let frames = document.look().frames.iter();
    let others = frames.map(|frame| frame.name.value.as_str());
    let others: Vec<&str> = others.filter(|title| Some(*title) != own).collect();
    let mut chosen = None;
    menu(ui, "Put into a frame", |ui| {
        for title in others {
            let entry = ui.button(title);
            name(&entry, &format!("Into frame {title}"));
            if entry.clicked() {
                chosen = Some(title.to_owned());
            }
        }
        if ui.button("A new frame").clicked() {
            chosen = Some(framing::free_title(document));
        }
    });
    if let Some(title) = chosen {
        let edits = framing::frame_material(document, material, &title);
        cx.edit(&format!("{material} into frame {title}"), edits, None);
        ui.close();
    }
    if own.is_some() && ui.button("Take out of the frame").clicked() {
        let edits = framing::unframe(document, &[], &[material.to_owned()]);
        cx.edit(&format!("take {material} out of its frame"), edits, None);
        ui.close();
    }
}

/// What was done with a frame.
struct Moved {
    by: egui::Vec2,
    is_chosen: bool,
}

fn show(ui: &mut Ui, cx: &mut Context<'_>, frame: &FrameLook, rect: Rect) -> Moved {
    let title = &frame.name.value;
    let head = rect.with_max_y(rect.top() + HEAD);
    let id = ui.scope_id().with(("frame", title));
    let handle = ui.interact(head, id, Sense::click_and_drag());
    describe(&handle, Role::Button, &format!("Frame {title}"));
    paint(ui, frame, rect, head);
    context_menu(&handle, |ui| frame_menu(ui, cx, title));
    let by_key = super::focus::moved(ui, &handle);
    Moved {
        by: handle.drag_delta() + by_key,
        is_chosen: handle.clicked(),
    }
}

fn paint(ui: &Ui, frame: &FrameLook, rect: Rect, head: Rect) {
    let visuals = ui.visuals();
    let color = match &frame.color {
        Some(color) => {
            let [r, g, b] = color.value.to_array().map(|x| x.clamp(0.0, 1.0));
            Color32::from(Rgba::from_rgb(r, g, b))
        }
        None => visuals.weak_text_color(),
    };
    let painter = ui.painter();
    painter.rect_filled(rect, 6.0, color.gamma_multiply(TINT));
    let behind = visuals.window_fill.lerp_to_gamma(color, HEAD_TINT);
    painter.rect_filled(head, 6.0, behind);
    painter.rect_stroke(rect, 6.0, Stroke::new(1.0, color), StrokeKind::Inside);
    let at = head.left_center() + vec2(10.0, 0.0);
    let font = FontId::proportional(13.0);
    let ink = visuals.strong_text_color();
    let painter = painter.with_clip_rect(head.intersect(ui.clip_rect()));
    painter.text(at, Align2::LEFT_CENTER, &frame.name.value, font, ink);
}

fn frame_menu(ui: &mut Ui, cx: &mut Context<'_>, title: &str) {
    let section = || Section::Frame(title.to_owned());
    menu(ui, "Rename", |ui| {
        let field = draft(ui, &format!("Title of {title}"), "title", title, 140.0);
        if let Some(new) = field.value {
            cx.rename_frame(title, new.trim());
            ui.close();
        }
    });
    menu(ui, "Colour", |ui| {
        let mut chosen = None;
        for (word, hex) in COLORS {
            let [r, g, b, _] = texgen::color_from_hex(hex).unwrap_or([0.5; 4]);
            let row = ui.horizontal(|ui| {
                let (place, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
                ui.painter()
                    .rect_filled(place, 2.0, Rgba::from_rgb(r, g, b));
                ui.button(word)
            });
            if row.inner.clicked() {
                chosen = Some(hex.to_owned());
            }
        }
        let label = format!("Colour of {title}");
        let field = draft(ui, &label, "#rrggbb", "", 90.0);
        chosen = chosen.or(field.value);
        if let Some(hex) = chosen {
            let edit = Edit::set(section(), "color", Value::Text(hex));
            cx.edit(&format!("colour of {title}"), vec![edit], None);
            ui.close();
        }
    });
    let button = ui.button("Remove the frame");
    name(&button, &format!("Remove the frame {title}"));
    if button.clicked() {
        let edit = Edit::Remove { section: section() };
        cx.edit(&format!("remove frame {title}"), vec![edit], None);
        ui.close();
    }
}
