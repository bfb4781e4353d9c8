//! The camera: which one, its lens, and back into the look.

use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{PopupCloseBehavior, Ui};
use engine::scene::look::{Section, Value};
use engine::scene::{Camera, Projection};
use engine::session::Edit;
use glam::Vec3;
use patina_panels::number_field;

use crate::link::{Command, Extent};
use crate::navigate::Navigator;

use super::Viewer;
use super::bars::dragged;
use super::motion::{FASTEST, SLOWEST};

/// Metres from the lens to the nearest plane that it can be focused on: a look takes nothing that isn't in front of it.
const NEAREST: f32 = 1e-6;

impl Viewer {
    pub(super) fn camera_menu(&mut self, ui: &mut Ui) {
        // By default a click into a field of a menu closes it: nothing could be written there.
        let stays = PopupCloseBehavior::CloseOnClickOutside;
        let config = MenuConfig::new().close_behavior(stays);
        let menu = MenuButton::new("Camera").config(config);
        menu.ui(ui, |ui| self.camera_entries(ui));
    }

    fn camera_entries(&mut self, ui: &mut Ui) {
        if ui.button("Of the look").on_hover_text("Home").clicked() {
            self.go_home();
            ui.close();
        }
        for (number, camera) in self.scene.cameras.clone().into_iter().enumerate() {
            let hint = match number {
                0..9 => format!("{}", number + 1),
                _ => "of the scene".to_owned(),
            };
            if ui.button(&camera.name).on_hover_text(hint).clicked() {
                self.look_through(camera);
                ui.close();
            }
        }
        for (text, keys, extent) in [
            ("Frame what was clicked", "F", Extent::Picked),
            ("Frame everything", "Shift F", Extent::Scene),
        ] {
            if ui.button(text).on_hover_text(keys).clicked() {
                self.link.send(Command::Bounds(extent));
                ui.close();
            }
        }
        ui.separator();
        self.lens(ui);
        ui.separator();
        self.movement(ui);
        ui.separator();
        let store = egui::Button::new("Put into the look");
        let is_other = self.viewport.has_own_view();
        let now = self.viewport.now();
        let is_parallel = now
            .is_some_and(|now| matches!(now.camera().projection, Projection::Orthographic { .. }));
        let store = ui.add_enabled(is_other && !is_parallel, store);
        let store = match is_parallel {
            true => store.on_disabled_hover_text("looks know perspective cameras alone"),
            false => store,
        };
        if store.clicked() {
            self.store_camera(ui.input(|input| input.time));
            ui.close();
        }
    }

    pub(super) fn go_home(&mut self) {
        self.viewport.go_home();
        self.link.send(Command::View(None));
    }

    pub(super) fn look_through(&mut self, camera: Camera) {
        let view = self.viewport.moved(|now| *now = Navigator::new(camera));
        self.send_view(view);
    }

    /// How the keys move the camera.
    fn movement(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            let label = ui.label("Speed");
            let pace = 0.02 * self.preferences.speed;
            let speed = egui::DragValue::new(&mut self.preferences.speed)
                .range(SLOWEST..=FASTEST)
                .speed(pace)
                .suffix(" x");
            number_field(ui, speed).labelled_by(label.id);
        });
        let mut walks = self.viewport.walks();
        let walk = ui.checkbox(&mut walks, "Walk on the ground");
        if walk.on_hover_text("G").changed() {
            self.toggle_walk();
        }
    }

    fn lens(&mut self, ui: &mut Ui) {
        let Some(navigator) = self.viewport.now() else {
            return;
        };
        let mut camera = navigator.camera().clone();
        let mut has_changed = false;
        egui::Grid::new("lens").num_columns(2).show(ui, |ui| {
            if let Projection::Perspective { y_fov } = &mut camera.projection {
                let label = ui.label("Field of view");
                let mut degrees = y_fov.to_degrees();
                let drag = egui::DragValue::new(&mut degrees)
                    .range(1.0..=170.0)
                    .clamp_existing_to_range(false)
                    .suffix("°");
                if number_field(ui, drag).labelled_by(label.id).changed() {
                    *y_fov = degrees.to_radians();
                    has_changed = true;
                }
                ui.end_row();
            }
            let mut millimetres = camera.aperture_radius * 1e3;
            let radius = &mut millimetres;
            if dragged(ui, "Aperture radius", radius, 0.0, 0.1, " mm") {
                camera.aperture_radius = millimetres * 1e-3;
                has_changed = true;
            }
            ui.end_row();
            let speed = 0.01 * camera.focus_distance.max(0.01);
            let focus = &mut camera.focus_distance;
            has_changed |= dragged(ui, "Focus", focus, NEAREST, speed, " m");
            ui.end_row();
        });
        if has_changed {
            let view = self.viewport.moved(|now| *now.camera_mut() = camera);
            self.send_view(view);
        }
    }

    /// Makes the camera that of the look.
    fn store_camera(&mut self, now: f64) {
        let Some(navigator) = self.viewport.now() else {
            return;
        };
        // What the look doesn't take goes on being looked through.
        let is_stored = self.edit("camera", &camera_edits(&navigator), now);
        // A camera that was asked for by name stays in the place of the look's.
        if is_stored && self.scene.files.camera.is_none() {
            self.go_home();
        }
    }
}

/// The keys of `[camera]` by which a look has this camera.
fn camera_edits(navigator: &Navigator) -> Vec<Edit> {
    let camera = navigator.camera();
    let place = |v: Vec3| Value::numbers(&v.to_array());
    let mut edits = vec![
        Edit::camera("position", place(camera.transform.translation.into())),
        Edit::camera("look_at", place(navigator.pivot())),
        Edit::camera("up", place(camera.transform.matrix3.y_axis.into())),
        Edit::camera("focus_distance", Value::number(camera.focus_distance)),
        Edit::camera("aperture_radius", Value::number(camera.aperture_radius)),
        // It would be stronger than the radius.
        Edit::Clear {
            section: Section::Camera,
            key: "f_number".to_owned(),
        },
    ];
    if let Projection::Perspective { y_fov } = camera.projection {
        edits.push(Edit::camera("y_fov", Value::number(y_fov.to_degrees())));
    }
    edits
}
