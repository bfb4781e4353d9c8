//! Menus that stay open while something is written in them.

use egui::containers::menu::{MenuButton, MenuConfig, SubMenuButton, is_in_menu};
use egui::{
    InnerResponse, Popup, PopupCloseBehavior, Response, ScrollArea, SetOpenCommand, Ui, UiKind,
    UiStackInfo,
};

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

/// A menu by right click on a widget.
pub(crate) fn context_menu(response: &Response, add: impl FnOnce(&mut Ui)) {
    let (opens, closes) = (response.secondary_clicked(), response.clicked());
    context_menu_if(response, opens, closes, add);
}

/// A menu by right click on anything in a row.
pub(crate) fn row_menu(row: &Response, add: impl FnOnce(&mut Ui)) {
    let (opens, closes) = (row.container_secondary_clicked(), row.container_clicked());
    context_menu_if(row, opens, closes, add);
}

fn context_menu_if(response: &Response, opens: bool, closes: bool, add: impl FnOnce(&mut Ui)) {
    let command = (opens || closes).then_some(SetOpenCommand::Bool(opens));
    let config = config();
    Popup::menu(response)
        .open_memory(command)
        .at_pointer_fixed()
        .close_behavior(config.close_behavior)
        .info(UiStackInfo::new(UiKind::Menu).with_tag_value(MenuConfig::MENU_CONFIG_TAG, config))
        .show(add);
}
