//! How the pointer and the keys move the camera.

use egui::{Event, EventFilter, Key, Modifiers, PointerButton, Rect, Ui};
use engine::scene::Camera;
use glam::Vec3;

use crate::link::Command;

use super::Viewer;
use super::viewport::Walk;

/// Of the distance per point of the wheel.
const WHEEL: f32 = 0.002;
/// Of the height of the picture, that an arrow is as good as the pointer moved by.
const KEY_MOTION: f32 = 0.04;
/// On the distance, by `-`.
const KEY_ZOOM: f32 = 1.1;
/// Flying while Shift is held is so many times faster.
const FAST: f32 = 4.0;
/// How slow and how fast it can be set.
pub(super) const SLOWEST: f32 = 0.01;
pub(super) const FASTEST: f32 = 100.0;
/// Frames per second while flying: more would take time from rendering.
const FLIGHT_FPS: f32 = 30.0;

impl Viewer {
    /// Moves the camera as the pointer and the keys say.
    pub(super) fn navigate(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &egui::Response,
    ) -> Option<Camera> {
        let mut view = None;
        let motion = response.drag_delta() / rect.height().max(1.0);
        let motion = glam::Vec2::new(motion.x, motion.y);
        let (shift, scroll) = ui.input(|i| (i.modifiers.shift, i.smooth_scroll_delta.y));
        if motion != glam::Vec2::ZERO {
            let has = |button| response.dragged_by(button);
            if has(PointerButton::Middle) || has(PointerButton::Primary) && shift {
                view = self.viewport.moved(|navigator| navigator.pan(motion));
            } else if has(PointerButton::Primary) {
                view = self.viewport.moved(|navigator| navigator.orbit(motion));
            } else if has(PointerButton::Secondary) {
                view = self.viewport.moved(|navigator| navigator.look(motion));
            }
        }
        if response.hovered() && scroll != 0.0 {
            let factor = (-scroll * WHEEL).exp();
            view = self.viewport.moved(|navigator| navigator.dolly(factor));
        }
        self.fly(ui, response).or(view)
    }

    /// Moves the camera by the arrows and `+`, `-`, while the picture has the keyboard.
    pub(super) fn navigate_by_keys(
        &mut self,
        ui: &Ui,
        response: &egui::Response,
    ) -> Option<Camera> {
        if !response.has_focus() {
            return None;
        }
        let filter = EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
        let arrows = |modifiers| {
            ui.input_mut(|input| {
                let mut count = |key| input.count_and_consume_key(modifiers, key) as f32;
                glam::Vec2::new(
                    count(Key::ArrowRight) - count(Key::ArrowLeft),
                    count(Key::ArrowDown) - count(Key::ArrowUp),
                )
            })
        };
        // The longer ones first: an arrow with Shift is an arrow, too.
        let (pan, orbit) = (arrows(Modifiers::SHIFT), arrows(Modifiers::NONE));
        // By what was typed: where these are depends on the keyboard.
        let nearer: i32 = ui.input(|input| {
            let signs = input.events.iter().map(|event| match event {
                Event::Text(text) if text == "+" => 1,
                Event::Text(text) if text == "-" => -1,
                _ => 0,
            });
            signs.sum()
        });
        if pan == glam::Vec2::ZERO && orbit == glam::Vec2::ZERO && nearer == 0 {
            return None;
        }
        self.viewport.moved(|navigator| {
            // Even a turn by nothing rounds.
            if orbit != glam::Vec2::ZERO {
                navigator.orbit(orbit * KEY_MOTION);
            }
            navigator.pan(pan * KEY_MOTION);
            navigator.dolly(KEY_ZOOM.powi(-nearer));
        })
    }

    fn fly(&mut self, ui: &Ui, response: &egui::Response) -> Option<Camera> {
        let was_flying = std::mem::take(&mut self.viewport.is_flying);
        let is_here = response.hovered() || response.dragged() || response.has_focus();
        if !is_here || ui.ctx().text_edit_focused() || self.dialog.is_some() {
            return None;
        }
        let (way, seconds) = ui.input(|input| {
            let held = |key| f32::from(u8::from(input.key_down(key)));
            let way = Vec3::new(
                held(Key::D) - held(Key::A),
                held(Key::E) - held(Key::Q),
                held(Key::W) - held(Key::S),
            );
            let is_command = input.modifiers.command || input.modifiers.alt;
            let factor = match (is_command, input.modifiers.shift) {
                (true, _) => 0.0,
                (false, true) => FAST,
                (false, false) => 1.0,
            };
            (way * factor, input.stable_dt)
        });
        if way == Vec3::ZERO {
            return None;
        }
        self.viewport.is_flying = true;
        let frame = std::time::Duration::from_secs_f32(1.0 / FLIGHT_FPS);
        ui.ctx().request_repaint_after(frame);
        // The first frame of a flight has been waited for, perhaps long.
        let seconds = match was_flying {
            true => seconds.min(0.1),
            false => 1.0 / FLIGHT_FPS,
        };
        let pace = seconds * self.preferences.speed.clamp(SLOWEST, FASTEST);
        let walks = self.viewport.walks();
        let view = self.viewport.moved(|navigator| {
            let way = way * (pace * navigator.speed());
            match walks {
                true => navigator.walk(glam::Vec2::new(way.x, way.z)),
                false => navigator.fly(way),
            }
        });
        self.ask_for_ground();
        view
    }

    /// Walks from now on in place of flying, or flies again.
    pub(super) fn toggle_walk(&mut self) {
        self.viewport.walk = match self.viewport.walk {
            Some(_) => None,
            None => Some(Walk::default()),
        };
        self.ask_for_ground();
    }

    fn ask_for_ground(&mut self) {
        let eye = self.viewport.now().map(|navigator| navigator.eye());
        if let (Some(walk), Some(eye)) = (&mut self.viewport.walk, eye)
            && !std::mem::replace(&mut walk.is_asking, true)
        {
            self.link.send(Command::Ground(eye));
        }
    }
}
