//! The menu of textures that nodes can be made of.

use egui::{Key, Ui};
use engine::session::summary;
use texgen::TextureType;

use crate::context::Context;
use crate::{edits, widgets};

/// The library, narrowed down by what is looked for. Gives the name of a node that was added.
pub(crate) fn add_menu(ui: &mut Ui, cx: &mut Context<'_>, search: &mut String) -> Option<String> {
    let field = egui::TextEdit::singleline(search).hint_text("search");
    let field = ui.add(field);
    widgets::name(&field, "Search textures");
    if is_new(ui, field.id) {
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
        let entry = ui.button(texture.name());
        let is_chosen = entry.clicked() || (i == 0 && by_enter);
        entry.on_hover_text(texture.docs());
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
