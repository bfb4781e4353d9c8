//! The menu of textures that nodes can be made of.

use egui::{Align2, DragAndDrop, FontId, Key, LayerId, Order, Response, Sense, Stroke, Ui, vec2};
use engine::session::summary;
use texgen::TextureType;

use crate::context::Context;
use crate::model::Target;
use crate::{edits, widgets};

/// Points of the picture of a texture.
const SWATCH: egui::Vec2 = egui::vec2(36.0, 36.0);

/// A texture that is dragged from the list of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct DraggedTexture(pub(crate) String);

/// A texture that is dropped on a row drives what the row is of.
pub(crate) fn take_texture(ui: &Ui, cx: &mut Context<'_>, row: &Response, target: &Target) {
    if row.dnd_hover_payload::<DraggedTexture>().is_some() {
        let stroke = Stroke::new(2.0, ui.visuals().selection.bg_fill);
        let painter = ui.painter();
        painter.rect_stroke(row.rect, 2.0, stroke, egui::StrokeKind::Inside);
    }
    if let Some(texture) = row.dnd_release_payload::<DraggedTexture>() {
        cx.add_linked(&texture.0, target);
    }
}

/// The name of a texture that is dragged, at the pointer.
pub(crate) fn show_dragged(ui: &Ui) {
    let Some(texture) = DragAndDrop::payload::<DraggedTexture>(ui.ctx()) else {
        return;
    };
    let Some(at) = ui.input(|input| input.pointer.latest_pos()) else {
        return;
    };
    let layer = LayerId::new(Order::Tooltip, egui::Id::unique("dragged texture"));
    let painter = ui.ctx().layer_painter(layer);
    let color = ui.visuals().strong_text_color();
    let font = FontId::proportional(13.0);
    let line = painter.layout_no_wrap(texture.0.clone(), font, color);
    let place = Align2::LEFT_TOP.anchor_size(at + vec2(12.0, 8.0), line.size());
    painter.rect_filled(place.expand(4.0), 3.0, ui.visuals().window_fill);
    painter.galley(place.min, line, color);
}

/// The library, narrowed down by what is looked for. Gives the name of a node that was added.
pub(crate) fn add_menu(ui: &mut Ui, cx: &mut Context<'_>, search: &mut String) -> Option<String> {
    let field = egui::TextEdit::singleline(search).hint_text("search");
    let field = ui.add(field);
    widgets::name(&field, "Search textures");
    // While a menu is measured nothing of it can be typed into.
    if !ui.is_sizing_pass() && is_new(ui, field.id) {
        field.request_focus();
    }
    let wanted = search.to_lowercase();
    let textures = cx.textures.library.textures().iter();
    let mut found: Vec<_> = textures
        .filter(|texture| {
            texture.name().to_lowercase().contains(&wanted)
                || texture.docs().to_lowercase().contains(&wanted)
        })
        .collect();
    // What is called so comes before what only mentions it.
    found.sort_by_key(|texture| !texture.name().to_lowercase().contains(&wanted));
    let by_enter = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    let added = widgets::scrolled(ui, |ui| {
        entries(ui, cx, &found, by_enter && !wanted.is_empty())
    });
    if added.is_some() {
        search.clear();
    }
    added
}

/// Textures to choose from, and those that have mistakes. Gives the name of a node that was added, by Enter of the first texture.
fn entries(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    found: &[&TextureType],
    by_enter: bool,
) -> Option<String> {
    let mut added = None;
    for (i, texture) in found.iter().enumerate() {
        let row = ui.horizontal(|ui| {
            swatch(ui, cx, texture.name());
            // All of the row is meant, not its letters.
            let width = match ui.is_sizing_pass() {
                true => 0.0,
                false => ui.available_width(),
            };
            let button = egui::Button::new((texture.name(), egui::Atom::grow()));
            ui.add((button.min_size(vec2(width, 0.0))).sense(Sense::click_and_drag()))
        });
        if row.inner.drag_started() {
            DragAndDrop::set_payload(ui.ctx(), DraggedTexture(texture.name().to_owned()));
            // It would lie over what the texture is dropped on.
            ui.close();
        }
        let is_chosen = row.inner.clicked() || (i == 0 && by_enter);
        row.inner.on_hover_text(texture.docs());
        if is_chosen && added.is_none() {
            let (name, edits) = edits::add_node(cx.document, texture.name());
            cx.edit(&format!("add {name}"), edits, None);
            added = Some(name);
            ui.close();
        }
    }
    if found.is_empty() {
        ui.weak("no texture is called so");
    }
    for (name, problems) in &cx.textures.broken {
        let entry = ui.add_enabled(false, egui::Button::new(name));
        entry.on_disabled_hover_text(summary(problems));
    }
    added
}

/// What a texture looks like by itself, where there are pictures at all.
fn swatch(ui: &mut Ui, cx: &mut Context<'_>, texture: &str) {
    let Some(previews) = &mut cx.previews else {
        return;
    };
    let (place, _) = ui.allocate_exact_size(SWATCH, egui::Sense::hover());
    if !ui.is_rect_visible(place) {
        return;
    }
    match previews.texture(ui.ctx(), cx.textures, texture) {
        Some(picture) => egui::Image::new((picture.id(), SWATCH)).paint_at(ui, place),
        None => {
            let background = ui.visuals().extreme_bg_color;
            ui.painter().rect_filled(place, 2.0, background);
        }
    }
}

/// Whether something is shown that was not a frame ago: what is written goes there then.
fn is_new(ui: &Ui, id: egui::Id) -> bool {
    let now = ui.ctx().cumulative_pass_nr();
    let id = id.with("seen");
    let last = ui.data_mut(|data| {
        let last: Option<u64> = data.get_temp(id);
        data.insert_temp(id, now);
        last
    });
    last.is_none_or(|last| last + 1 < now)
}
