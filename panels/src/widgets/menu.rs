//! Menus that stay open while something is written in them.

use egui::containers::menu::{MenuButton, MenuConfig, SubMenuButton, is_in_menu};
use egui::{
    Id, InnerResponse, Popup, PopupCloseBehavior, Response, ScrollArea, SetOpenCommand, Ui, UiKind,
    UiStackInfo,
};

use super::focus::{asked_in, asks_for_menu};

fn config() -> MenuConfig {
    // By default a click into a text field of a menu closes it. What is done by an entry closes it by `Ui::close`.
    MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside)
}

/// A button that opens a menu, or one below the menu that it stands in.
pub(crate) fn menu<R>(
    ui: &mut Ui,
    text: &str,
    add: impl FnOnce(&mut Ui) -> R,
) -> InnerResponse<Option<R>> {
    let (response, inner) = match is_in_menu(ui) {
        true => SubMenuButton::new(text).config(config()).ui(ui, add),
        false => MenuButton::new(text).config(config()).ui(ui, add),
    };
    InnerResponse::new(inner.map(|inner| inner.inner), response)
}

/// A list in a menu: as long as it is, and no higher than the window allows, as menus themselves don't scroll.
pub(crate) fn scrolled<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
    let most = (0.6 * ui.ctx().content_rect().height()).max(80.0);
    let area = ScrollArea::vertical().max_height(most);
    area.show(ui, add).inner
}

/// A menu by right click on a widget, or by the keyboard where that has it.
pub(crate) fn context_menu(response: &Response, add: impl FnOnce(&mut Ui)) {
    let (opens, closes) = (response.secondary_clicked(), response.clicked());
    let by_key = asks_for_menu(response).then_some(response.id);
    context_menu_if(response, opens, closes, by_key, add);
}

/// A menu by right click on anything in a row, or by the keyboard where that is in it.
pub(crate) fn row_menu(row: &Response, add: impl FnOnce(&mut Ui)) {
    let (opens, closes) = (row.container_secondary_clicked(), row.container_clicked());
    context_menu_if(row, opens, closes, asked_in(row), add);
}

/// How a menu was opened by the keyboard.
#[derive(Debug, Clone, Copy)]
struct ByKey {
    /// What had the keyboard, and gets it again.
    opener: Id,
    /// The menu has it.
    is_entered: bool,
}

fn context_menu_if(
    response: &Response,
    opens: bool,
    closes: bool,
    by_key: Option<Id>,
    add: impl FnOnce(&mut Ui),
) {
    let ctx = &response.ctx;
    let id = Popup::default_response_id(response).with("by key");
    let mut known: Option<ByKey> = ctx.data(|data| data.get_temp(id));
    if let Some(opener) = by_key {
        let is_entered = false;
        known = Some(ByKey { opener, is_entered });
    } else if opens || closes {
        known = None;
    }
    let opens = opens || by_key.is_some();
    let command = (opens || closes).then_some(SetOpenCommand::Bool(opens));
    let config = config();
    let menu = Popup::menu(response).open_memory(command);
    let opener = known.and_then(|known| ctx.read_response(known.opener));
    let menu = match &opener {
        Some(opener) => menu.anchor(opener),
        None => menu.at_pointer_fixed(),
    };
    let shown = menu
        .close_behavior(config.close_behavior)
        .info(UiStackInfo::new(UiKind::Menu).with_tag_value(MenuConfig::MENU_CONFIG_TAG, config))
        .show(|ui| {
            add(ui);
            if let Some(known) = &mut known
                && !known.is_entered
            {
                known.is_entered = enter(ui);
            }
        });
    match (known, shown) {
        (Some(known), Some(_)) => {
            ctx.data_mut(|data| data.insert_temp(id, known));
        }
        (Some(known), None) => {
            ctx.data_mut(|data| data.remove::<ByKey>(id));
            ctx.memory_mut(|memory| memory.request_focus(known.opener));
        }
        (None, _) if opens || closes => ctx.data_mut(|data| data.remove::<ByKey>(id)),
        (None, _) => {}
    }
}

/// Gives the keyboard to the first entry of a menu, once there is one.
fn enter(ui: &Ui) -> bool {
    if ui.is_sizing_pass() {
        return false;
    }
    let first = ui.ctx().viewport(|viewport| {
        let mut widgets = viewport.this_pass.widgets.get_layer(ui.layer_id());
        let first = widgets.find(|widget| widget.enabled && widget.sense.is_focusable());
        first.map(|widget| widget.id)
    });
    if let Some(first) = first {
        ui.memory_mut(|memory| memory.request_focus(first));
    }
    first.is_some()
}
