//! Widgets for values of all types. They know neither looks nor history: each shows a value and says what it becomes.

mod browse;
mod focus;
mod image_slot;
mod menu;
mod number;
mod ramp;
mod value;

use egui::accesskit::Role;
use egui::{Response, Ui, WidgetInfo};

pub use browse::{Answer, Browser, Choice, FileDialogs, FileRequest, Purpose, named_from};
pub use focus::{asks_for_menu, keyboard_is_used, show_focus};
pub(crate) use image_slot::{ImageSlot, image_slot, is_image};
pub(crate) use menu::{context_menu, menu, row_menu, scrolled};
pub use number::number_field;
pub(crate) use value::{Bounds, Spec, edit_steady};

/// What a widget shows, and what it has become.
pub(crate) struct Edited<T> {
    /// Of the whole widget: for tooltips and context menus.
    pub(crate) response: Response,
    /// The new value, where it was changed.
    pub(crate) value: Option<T>,
}

/// Gives a widget the name by which assistive technology finds it, and so do tests.
pub(crate) fn name(response: &Response, name: &str) {
    let ctx = &response.ctx;
    let place = match ctx.layer_transform_to_global(response.layer_id) {
        Some(to_global) => to_global * response.rect,
        None => response.rect,
    };
    ctx.accesskit_node_builder(response.id, |node| {
        node.set_label(name);
        node.clear_labelled_by();
        node.set_bounds(egui::accesskit::Rect {
            x0: place.min.x.into(),
            y0: place.min.y.into(),
            x1: place.max.x.into(),
            y1: place.max.y.into(),
        });
    });
}

/// Makes something that was painted by hand a widget with a name.
pub(crate) fn describe(response: &Response, role: Role, label: &str) {
    response.widget_info(|| WidgetInfo::labeled(role, true, label));
    name(response, label);
}

/// A line with a label on the left, which `help` explains, and a widget on the right. Gives the response of the whole.
pub(crate) fn row<R>(
    ui: &mut Ui,
    label: &str,
    help: &str,
    is_set: bool,
    add: impl FnOnce(&mut Ui) -> R,
) -> (Response, R) {
    let row = ui.horizontal_wrapped(|ui| {
        let text = egui::RichText::new(label);
        let text = if is_set { text.strong() } else { text };
        let size = egui::vec2(
            (ui.available_width() * 0.38).clamp(60.0, 220.0),
            ui.spacing().interact_size.y,
        );
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_width(size.x);
            let label = ui.add(egui::Label::new(text).truncate());
            if !help.is_empty() {
                label.on_hover_text(help);
            }
        });
        // As wide as the panel allows, with room for the number behind it.
        ui.spacing_mut().slider_width =
            (ui.available_size_before_wrap().x - 96.0).clamp(60.0, 260.0);
        add(ui)
    });
    (row.response, row.inner)
}

/// A field for a text that means something only when it is complete, such as a path: it counts when the field is left,
/// unless by Escape.
pub(crate) fn draft(
    ui: &mut Ui,
    label: &str,
    hint: &str,
    current: &str,
    width: f32,
) -> Edited<String> {
    let id = ui.scope_id().with((label, "draft"));
    let draft: Option<String> = ui.data(|data| data.get_temp(id));
    let mut text = draft.unwrap_or_else(|| current.to_owned());
    let width = ui.available_width().min(width);
    let field = egui::TextEdit::singleline(&mut text)
        .hint_text(hint)
        .desired_width(width);
    let response = ui.add(field);
    name(&response, label);
    if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, text));
        return Edited {
            response,
            value: None,
        };
    }
    ui.data_mut(|data| data.remove::<String>(id));
    let is_given_up = ui.input(|input| input.key_pressed(egui::Key::Escape));
    let is_meant = response.lost_focus() && !is_given_up && text != current;
    Edited {
        response,
        value: is_meant.then_some(text),
    }
}

/// A choice of some words.
pub(crate) fn choice(ui: &mut Ui, label: &str, selected: &str, words: &[&str]) -> Edited<String> {
    let mut value = None;
    let shown = egui::ComboBox::from_id_salt(label)
        .selected_text(selected)
        .show_ui(ui, |ui| {
            for &word in words {
                let entry = ui.selectable_label(word == selected, word);
                if entry.clicked() && word != selected {
                    value = Some(word.to_owned());
                }
            }
        });
    name(&shown.response, label);
    Edited {
        response: shown.response,
        value,
    }
}
