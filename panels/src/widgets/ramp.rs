//! The editor of ramps: a bar of colours with stops on it, and a curve where the colours are greys.
//!
//! A click on the bar adds a stop, dragging moves it, Delete or the button takes it away. With the keyboard on a stop, arrows move it,
//! Insert adds another one behind it, Enter goes to its colour.

use egui::accesskit::Role;
use egui::{
    Color32, EventFilter, Id, Key, Mesh, Modifiers, Popup, Pos2, Rect, Response, Sense, Shape,
    Stroke, StrokeKind, Ui, pos2, vec2,
};
use texgen::{Interpolation, Ramp};

use super::number::number_field;
use super::{Edited, choice, describe, name};

const HEIGHT: f32 = 22.0;
const CURVE_HEIGHT: f32 = 64.0;
const HANDLE: f32 = 6.0;
/// Share of the ramp that an arrow moves a stop by; with Shift.
const STEP: f32 = 0.01;
const FINE_STEP: f32 = 0.001;
const WORDS: [(&str, Interpolation); 3] = [
    ("linear", Interpolation::Linear),
    ("smooth", Interpolation::Smooth),
    ("constant", Interpolation::Constant),
];

/// Shows a ramp; `label` is what it is found by.
pub(super) fn edit(ui: &mut Ui, label: &str, ramp: &Ramp) -> Edited<Ramp> {
    let mut shown = ramp.clone();
    // As they are used; equal positions keep their order.
    shown.stops.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut changed = false;
    let id = ui.scope_id().with(label);
    let mut selected: usize = ui.data(|data| data.get_temp(id)).unwrap_or(0);
    selected = selected.min(shown.stops.len().saturating_sub(1));
    let area = ui.vertical(|ui| {
        let is_curve = shown.stops.iter().all(|(_, [r, g, b, _])| r == g && g == b);
        changed |= bar(ui, label, &mut shown, &mut selected, is_curve);
        ui.horizontal_wrapped(|ui| changed |= details(ui, label, &mut shown, &mut selected));
    });
    ui.data_mut(|data| data.insert_temp(id, selected));
    Edited {
        response: area.response,
        value: changed.then_some(shown),
    }
}

/// Where a ramp begins and ends: at least from 0 to 1.
fn extent(ramp: &Ramp) -> (f32, f32) {
    let positions = ramp.stops.iter().map(|stop| stop.0);
    let (low, high) = positions.fold((0f32, 1f32), |(low, high), at| (low.min(at), high.max(at)));
    (low, high)
}

/// The colour at a position, as the kernel finds it.
pub(crate) fn color_at(ramp: &Ramp, at: f32) -> [f32; 4] {
    let stops = &ramp.stops;
    let next = stops.partition_point(|stop| stop.0 <= at);
    let (Some(before), Some(after)) = (
        next.checked_sub(1).and_then(|i| stops.get(i)),
        stops.get(next),
    ) else {
        // Outside, or without any stop.
        let end = if next == 0 {
            stops.first()
        } else {
            stops.last()
        };
        return end.map_or([0.0; 4], |stop| stop.1);
    };
    let t = (at - before.0) / (after.0 - before.0).max(f32::MIN_POSITIVE);
    let t = match ramp.interpolation {
        Interpolation::Linear => t,
        Interpolation::Smooth => t * t * (3.0 - 2.0 * t),
        Interpolation::Constant => 0.0,
    };
    std::array::from_fn(|i| before.1[i] + t * (after.1[i] - before.1[i]))
}

fn shown_color([r, g, b, _]: [f32; 4]) -> Color32 {
    egui::Rgba::from_rgb(r.clamp(0.0, 1.0), g.clamp(0.0, 1.0), b.clamp(0.0, 1.0)).into()
}

/// The bar with its stops, and above it the curve.
fn bar(ui: &mut Ui, label: &str, ramp: &mut Ramp, selected: &mut usize, is_curve: bool) -> bool {
    let height = HEIGHT + if is_curve { CURVE_HEIGHT } else { 0.0 };
    let width = ui.available_width().clamp(80.0, 400.0);
    let size = vec2(width, height + HANDLE);
    let (area, response) = ui.allocate_exact_size(size, Sense::click());
    describe(&response, Role::Button, label);
    let inner = area.shrink2(vec2(HANDLE, 0.0));
    let colors = Rect::from_min_max(pos2(inner.left(), inner.top() + height - HEIGHT), inner.max);
    let colors = colors.with_max_y(area.bottom() - HANDLE);
    let curve = inner.with_max_y(colors.top());
    let (low, high) = extent(ramp);
    let x_of = |at: f32| egui::lerp(inner.x_range(), (at - low) / (high - low));
    let at_of = |x: f32| low + (high - low) * ((x - inner.left()) / inner.width()).clamp(0.0, 1.0);

    paint_colors(ui, ramp, colors, at_of);
    let top = ramp.stops.iter().map(|stop| stop.1[0]).fold(1f32, f32::max);
    let y_of = |value: f32| egui::lerp(curve.bottom()..=curve.top(), (value / top).clamp(0.0, 1.0));
    if is_curve {
        paint_curve(ui, ramp, curve, at_of, y_of);
    }

    let mut changed = false;
    if response.clicked()
        && let Some(pointer) = response.interact_pointer_pos()
    {
        let at = round(at_of(pointer.x));
        let place = ramp.stops.partition_point(|stop| stop.0 <= at);
        ramp.stops.insert(place, (at, color_at(ramp, at)));
        *selected = place;
        changed = true;
        // Keys are for the new one, once this click is over: it would take the keyboard from there.
        ui.data_mut(|data| data.insert_temp(response.id, place));
        ui.ctx().request_repaint();
    } else if let Some(place) = ui.data_mut(|data| data.remove_temp::<usize>(response.id)) {
        let id = response.id.with(("stop", place));
        ui.memory_mut(|memory| memory.request_focus(id));
    }
    let mut moved = None;
    let mut pressed = None;
    for (i, &(at, color)) in ramp.stops.iter().enumerate() {
        let center = match is_curve {
            true => pos2(x_of(at), y_of(color[0])),
            false => pos2(x_of(at), colors.bottom()),
        };
        let place = Rect::from_center_size(center, vec2(2.0 * HANDLE, 2.0 * HANDLE));
        let id = response.id.with(("stop", i));
        let handle = ui.interact(place, id, Sense::click_and_drag());
        describe(&handle, Role::Button, &format!("{label} stop {i}"));
        if handle.clicked() || handle.drag_started() || handle.gained_focus() {
            *selected = i;
        }
        if handle.clicked() || handle.drag_started() {
            handle.request_focus();
        }
        if let Some(key) = stop_key(ui, &handle) {
            pressed = Some((i, key));
        }
        if handle.dragged()
            && let Some(pointer) = handle.interact_pointer_pos()
        {
            let value = match is_curve {
                true => {
                    round(top * ((curve.bottom() - pointer.y) / curve.height()).clamp(0.0, 1.0))
                }
                false => color[0],
            };
            moved = Some((i, round(at_of(pointer.x)), value));
        }
        let is_selected = i == *selected;
        let stroke = match is_selected {
            true => Stroke::new(2.0, ui.visuals().strong_text_color()),
            false => Stroke::new(1.0, ui.visuals().text_color()),
        };
        let painter = ui.painter();
        painter.circle(center, HANDLE - 1.0, shown_color(color), stroke);
    }
    if let Some((i, at, value)) = moved {
        // Between its neighbours, so that it stays the one that is dragged.
        let before = i
            .checked_sub(1)
            .map_or(f32::NEG_INFINITY, |i| ramp.stops[i].0);
        let after = ramp.stops.get(i + 1).map_or(f32::INFINITY, |stop| stop.0);
        let stop = &mut ramp.stops[i];
        let was = *stop;
        stop.0 = at.clamp(before, after);
        if is_curve {
            stop.1 = [value, value, value, stop.1[3]];
        }
        changed |= *stop != was;
    }
    if let Some((i, key)) = pressed {
        let focus = |i: usize| {
            let id = response.id.with(("stop", i));
            ui.memory_mut(|memory| memory.request_focus(id));
        };
        match key {
            StopKey::Move(by, rise) => {
                let before = i.checked_sub(1).map_or(low, |i| ramp.stops[i].0);
                let after = ramp.stops.get(i + 1).map_or(high, |stop| stop.0);
                let stop = &mut ramp.stops[i];
                let was = *stop;
                let at = round(stop.0 + by * (high - low));
                // One that is outside already is not drawn in.
                stop.0 = at.clamp(before.min(stop.0), after.max(stop.0));
                if is_curve {
                    let value = round((stop.1[0] + rise * top).max(0.0));
                    stop.1 = [value, value, value, stop.1[3]];
                }
                changed |= *stop != was;
            }
            StopKey::Insert => {
                let at = ramp.stops[i].0;
                let next = ramp.stops.get(i + 1).map_or(high, |stop| stop.0);
                let between = 0.5 * (at + next);
                ramp.stops.insert(i + 1, (between, color_at(ramp, between)));
                *selected = i + 1;
                focus(i + 1);
                changed = true;
            }
            StopKey::Delete if ramp.stops.len() > 1 => {
                ramp.stops.remove(i);
                *selected = i.min(ramp.stops.len() - 1);
                focus(*selected);
                changed = true;
            }
            StopKey::Delete => {}
            StopKey::Edit => {
                *selected = i;
                let id = edits_color(ui, label);
                ui.data_mut(|data| data.insert_temp(id, true));
            }
        }
    }
    changed
}

/// What a key does to the stop that has the keyboard.
#[derive(Debug, Clone, Copy, PartialEq)]
enum StopKey {
    /// By a share of the ramp, and of the curve's height.
    Move(f32, f32),
    Insert,
    Delete,
    /// Its colour.
    Edit,
}

fn stop_key(ui: &Ui, stop: &Response) -> Option<StopKey> {
    if !stop.has_focus() {
        return None;
    }
    let filter = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        ..EventFilter::default()
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(stop.id, filter));
    ui.input_mut(|input| {
        for (modifiers, step) in [(Modifiers::SHIFT, FINE_STEP), (Modifiers::NONE, STEP)] {
            let mut count = |key| input.count_and_consume_key(modifiers, key) as f32;
            let by = count(Key::ArrowRight) - count(Key::ArrowLeft);
            let rise = count(Key::ArrowUp) - count(Key::ArrowDown);
            if by != 0.0 || rise != 0.0 {
                return Some(StopKey::Move(by * step, rise * step));
            }
        }
        let keys = [
            (Key::Insert, StopKey::Insert),
            (Key::Delete, StopKey::Delete),
            (Key::Enter, StopKey::Edit),
        ];
        let mut keys = keys.into_iter();
        keys.find(|(key, _)| input.consume_key(Modifiers::NONE, *key))
            .map(|(_, deed)| deed)
    })
}

/// Where it is kept that the colour of the selected stop is to be edited.
fn edits_color(ui: &Ui, label: &str) -> Id {
    ui.ctx().viewport_id().0.with((label, "edits colour"))
}

fn paint_colors(ui: &Ui, ramp: &Ramp, place: Rect, at_of: impl Fn(f32) -> f32) {
    let columns = place.width().max(1.0) as u32;
    let mut mesh = Mesh::default();
    for column in 0..columns {
        let x = place.left() + column as f32;
        let color = shown_color(color_at(ramp, at_of(x + 0.5)));
        let strip = Rect::from_min_max(pos2(x, place.top()), pos2(x + 1.0, place.bottom()));
        mesh.add_colored_rect(strip, color);
    }
    ui.painter().add(Shape::mesh(mesh));
    let stroke = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter()
        .rect_stroke(place, 0.0, stroke, StrokeKind::Outside);
}

fn paint_curve(
    ui: &Ui,
    ramp: &Ramp,
    place: Rect,
    at_of: impl Fn(f32) -> f32,
    y_of: impl Fn(f32) -> f32,
) {
    let visuals = ui.visuals();
    ui.painter()
        .rect_filled(place, 0.0, visuals.extreme_bg_color);
    let steps = place.width().max(1.0) as u32;
    let points: Vec<Pos2> = (0..=steps)
        .map(|step| {
            let x = place.left() + step as f32;
            pos2(x, y_of(color_at(ramp, at_of(x))[0]))
        })
        .collect();
    let stroke = Stroke::new(1.5, visuals.text_color());
    ui.painter().add(Shape::line(points, stroke));
}

/// Position and colour of the selected stop, and how the ramp goes from stop to stop.
fn details(ui: &mut Ui, label: &str, ramp: &mut Ramp, selected: &mut usize) -> bool {
    let mut changed = false;
    let i = *selected;
    let before = i.checked_sub(1).map_or(f32::MIN, |i| ramp.stops[i].0);
    let after = ramp.stops.get(i + 1).map_or(f32::MAX, |stop| stop.0);
    if let Some(stop) = ramp.stops.get_mut(i) {
        let position = egui::DragValue::new(&mut stop.0)
            .speed(0.003)
            .range(before..=after)
            .clamp_existing_to_range(false)
            .max_decimals(4);
        let position = number_field(ui, position);
        name(&position, &format!("{label} position"));
        changed |= position.changed();
        let mut rgb = [stop.1[0], stop.1[1], stop.1[2]];
        // The button's own id: egui makes the one of its popup so.
        let popup = ui.auto_id_with("popup");
        let picker = ui.color_edit_button_rgb(&mut rgb);
        name(&picker, &format!("{label} colour"));
        let asked = edits_color(ui, label);
        if ui
            .data_mut(|data| data.remove_temp::<bool>(asked))
            .is_some()
        {
            picker.request_focus();
            Popup::open_id(ui.ctx(), popup);
        }
        if picker.changed() && rgb.iter().all(|x| x.is_finite()) {
            stop.1[..3].copy_from_slice(&rgb);
            changed = true;
        }
    }
    let word = WORDS.iter().find(|(_, kind)| *kind == ramp.interpolation);
    let words = WORDS.map(|(word, _)| word);
    let kind = choice(
        ui,
        &format!("{label} interpolation"),
        word.map_or("", |(word, _)| word),
        &words,
    );
    if let Some(word) = kind.value {
        let found = WORDS.iter().find(|(known, _)| *known == word);
        ramp.interpolation = found.map_or(ramp.interpolation, |(_, kind)| *kind);
        changed = true;
    }
    let can_delete = ramp.stops.len() > 1;
    let delete = ui.add_enabled(can_delete, egui::Button::new("Delete stop"));
    name(&delete, &format!("{label} delete stop"));
    let is_hovered = ui.rect_contains_pointer(ui.min_rect()) && !ui.text_edit_focused();
    let by_key = is_hovered && ui.input(|input| input.key_pressed(Key::Delete));
    if can_delete && (delete.clicked() || by_key) {
        ramp.stops.remove(i);
        *selected = i.min(ramp.stops.len() - 1);
        changed = true;
    }
    changed
}

/// To what a hand can mean.
fn round(x: f32) -> f32 {
    (x * 1000.0).round() / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_between_stops() {
        let grey = |x: f32| [x, x, x, 1.0];
        let mut ramp = Ramp {
            stops: vec![(0.0, grey(0.0)), (0.5, grey(1.0)), (0.5, grey(0.0))],
            interpolation: Interpolation::Linear,
        };
        let value = |ramp: &Ramp, at| color_at(ramp, at)[0];
        assert_eq!(value(&ramp, -1.0), 0.0);
        assert_eq!(value(&ramp, 0.25), 0.5);
        assert_eq!(value(&ramp, 0.5), 0.0, "a hard step");
        assert_eq!(value(&ramp, 9.0), 0.0);
        ramp.interpolation = Interpolation::Smooth;
        assert_eq!(value(&ramp, 0.125), 0.15625);
        ramp.interpolation = Interpolation::Constant;
        assert_eq!(value(&ramp, 0.49), 0.0);
        ramp.stops.clear();
        assert_eq!(color_at(&ramp, 0.0), [0.0; 4]);
    }
}
