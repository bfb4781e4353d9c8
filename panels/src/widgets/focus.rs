//! Where the keyboard is: seen, and asked for.

use egui::{Context, Event, Id, Key, LayerId, Modifiers, Order, Response, Stroke, StrokeKind};

/// Draws a line around the widget that has the keyboard, from when the keyboard is used until the pointer is: to be called when all has
/// been shown.
pub fn show_focus(ctx: &Context) {
    let id = used_id();
    let is_way = |event: &Event| {
        let ways = [
            Key::Tab,
            Key::ArrowUp,
            Key::ArrowDown,
            Key::ArrowLeft,
            Key::ArrowRight,
        ];
        matches!(event, Event::Key { key, pressed: true, .. } if ways.contains(key))
    };
    let (by_key, by_pointer) = ctx.input(|input| {
        let by_key = input.raw.events.iter().any(is_way);
        (by_key, input.pointer.any_pressed())
    });
    let is_used = by_key || keyboard_is_used(ctx) && !by_pointer;
    ctx.data_mut(|data| data.insert_temp(id, is_used));
    let focused = ctx.memory(|memory| memory.focused());
    let Some(response) = focused
        .filter(|_| is_used)
        .and_then(|id| ctx.read_response(id))
    else {
        return;
    };
    let mut seen = response.interact_rect;
    if let Some(to_global) = ctx.layer_transform_to_global(response.layer_id) {
        seen = to_global * seen;
    }
    if !seen.is_positive() {
        return;
    }
    let painter = ctx.layer_painter(LayerId::new(Order::Tooltip, id));
    let color = ctx.global_style().visuals.hyperlink_color;
    let stroke = Stroke::new(2.0, color);
    // Within the window, also around what fills it.
    let seen = seen.expand(2.0).intersect(ctx.content_rect().shrink(2.0));
    painter.rect_stroke(seen, 3.0, stroke, StrokeKind::Inside);
}

/// Whether widgets are gone through by the keyboard, as far as [`show_focus`] has seen.
pub fn keyboard_is_used(ctx: &Context) -> bool {
    ctx.data(|data| data.get_temp(used_id())).unwrap_or(false)
}

fn used_id() -> Id {
    Id::unique("where the keyboard is")
}

/// Whether the menu of a widget is asked for by the keyboard, which is there.
pub fn asks_for_menu(response: &Response) -> bool {
    response.has_focus() && is_asked(&response.ctx)
}

/// The widget in a row that has the keyboard, where its menu is asked for by that.
pub(super) fn asked_in(row: &Response) -> Option<Id> {
    let focused = row.ctx.memory(|memory| memory.focused())?;
    let response = row.ctx.read_response(focused)?;
    let is_in = response.layer_id == row.layer_id && row.rect.contains(response.rect.center());
    (is_in && is_asked(&row.ctx)).then_some(focused)
}

/// Shift F10, or the key for it.
fn is_asked(ctx: &Context) -> bool {
    ctx.input_mut(|input| {
        input.consume_key(Modifiers::SHIFT, Key::F10)
            || input.consume_key(Modifiers::NONE, Key::Menu)
    })
}
