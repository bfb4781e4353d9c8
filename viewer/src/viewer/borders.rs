//! Borders that the keyboard moves: of panels, between pictures that are compared, and of the region.

use std::ops::RangeInclusive;

use egui::accesskit::{Action, ActionData, ActionRequest, Role, TreeId};
use egui::containers::panel::PanelState;
use egui::{Event, EventFilter, Id, Key, Modifiers, Rect, Sense, Ui, Vec2, WidgetInfo};

use super::{LEAST_PICTURE, call_id};

/// Points by an arrow, and with Shift.
const STEP: f32 = 20.0;
const FINE: f32 = 2.0;

/// Which way a border goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// To the left and the right.
    Across,
    /// Up and down.
    Along,
}

impl Way {
    fn of(self, size: Vec2) -> f32 {
        match self {
            Self::Across => size.x,
            Self::Along => size.y,
        }
    }
}

/// Borders that there are, and what is to become of the one that has the keyboard.
#[derive(Debug, Default)]
pub(super) struct Borders {
    shown: Vec<Id>,
    motion: Option<(Id, Motion)>,
}

#[derive(Debug, Clone, Copy)]
enum Motion {
    /// Points.
    By(Vec2),
    /// As far as it goes to the left or up, to the right or down.
    First,
    Last,
}

impl Borders {
    /// Takes the keys that are for a border of the last frame, before anything else does.
    pub(super) fn take_keys(&mut self, ui: &Ui) {
        self.motion = None;
        let shown = std::mem::take(&mut self.shown);
        let focused = ui.memory(|memory| memory.focused());
        let Some(id) = focused.filter(|id| shown.contains(id)) else {
            return;
        };
        let filter = EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(id, filter));
        self.motion = ui.input_mut(|input| {
            if input.consume_key(Modifiers::NONE, Key::Home) {
                return Some((id, Motion::First));
            }
            if input.consume_key(Modifiers::NONE, Key::End) {
                return Some((id, Motion::Last));
            }
            let mut arrows = |modifiers| {
                let mut count = |key| input.count_and_consume_key(modifiers, key) as f32;
                Vec2::new(
                    count(Key::ArrowRight) - count(Key::ArrowLeft),
                    count(Key::ArrowDown) - count(Key::ArrowUp),
                )
            };
            // The longer ones first: an arrow with Shift is an arrow, too.
            let by = FINE * arrows(Modifiers::SHIFT) + STEP * arrows(Modifiers::NONE);
            (by != Vec2::ZERO).then_some((id, Motion::By(by)))
        });
    }

    /// Where a border goes by the keys of this frame, points.
    fn moved(&mut self, id: Id, way: Way, at: f32, range: RangeInclusive<f32>) -> Option<f32> {
        self.shown.push(id);
        let (_, motion) = self.motion.filter(|(moved, _)| *moved == id)?;
        let to = match motion {
            Motion::By(by) => at + way.of(by),
            Motion::First => *range.start(),
            Motion::Last => *range.end(),
        };
        let to = to.clamp(*range.start(), range.end().max(*range.start()));
        (to != at).then_some(to)
    }

    /// Moves the border of a panel at the right or at the bottom, before that is shown.
    pub(super) fn before_panel(&mut self, ui: &Ui, salt: &str, way: Way, least: f32) {
        let (panel, id) = ids(ui, salt);
        let Some(state) = PanelState::load(ui.ctx(), panel) else {
            return;
        };
        let whole = way.of(ui.available_size_before_wrap()).max(1.0);
        let at = whole - way.of(state.size());
        let range = LEAST_PICTURE.min(whole)..=(whole - least).max(0.0);
        let Some(to) = self.moved(id, way, at, range) else {
            return;
        };
        // As assistive technology would ask for it.
        let share = f64::from((whole - to) / whole);
        let request = ActionRequest {
            action: Action::SetValue,
            target_tree: TreeId::ROOT,
            target_node: id.accesskit_id(),
            data: Some(ActionData::NumericValue(share)),
        };
        let event = Event::AccessKitActionRequest(request);
        ui.input_mut(|input| input.events.push(event));
    }

    /// Gives the border of a panel a name, once that has been shown.
    pub(super) fn name_panel(ui: &Ui, salt: &str, name: &str) {
        call_id(ui.ctx(), ids(ui, salt).1, name);
    }

    /// A border within something, which the pointer moves by other means: where the keys put it, 0 to 1.
    pub(super) fn line(
        &mut self,
        ui: &Ui,
        name: &str,
        way: Way,
        (whole, line): (Rect, Rect),
        (at, range): (f32, RangeInclusive<f32>),
    ) -> Option<f32> {
        let id = ui.scope_id().with(name);
        let response = ui.interact(line, id, Sense::focusable_noninteractive());
        response.widget_info(|| {
            let mut info = WidgetInfo::labeled(Role::Splitter, true, name);
            info.value = Some(f64::from(at));
            info
        });
        let size = way.of(whole.size()).max(1.0);
        let range = size * range.start()..=size * range.end();
        let to = self.moved(id, way, size * at, range)?;
        Some(to / size)
    }

    /// Has the keyboard go to a border within something.
    pub(super) fn focus(ui: &Ui, name: &str) {
        let id = ui.scope_id().with(name);
        ui.memory_mut(|memory| memory.request_focus(id));
    }
}

/// A panel's id, and that of its border: as egui makes them.
fn ids(ui: &Ui, salt: &str) -> (Id, Id) {
    let panel = ui.scope_id().with(salt);
    (panel, panel.with("__resize"))
}
