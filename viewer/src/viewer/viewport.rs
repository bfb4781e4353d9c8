//! The picture, and what the pointer and the keys do in it.

use egui::{
    Align2, Color32, Event, EventFilter, Key, Modifiers, PointerButton, Pos2, Rect, Sense, Stroke,
    StrokeKind, Ui, Vec2, pos2,
};
use engine::display::Channel;
use engine::scene::Camera;
use glam::Vec3;
use patina_panels::{DraggedMaterial, Placing, keyboard_is_used};

use crate::link::{Command, PickPurpose, SceneFacts};
use crate::navigate::Navigator;

use super::Viewer;
use super::borders::{Borders, Way};

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
/// Points around the border between both pictures in which it can be taken.
const GRIP: f32 = 6.0;
/// Borders of the region, in the order of its corners.
const REGION: [(&str, Way); 4] = [
    ("Left border of the region", Way::Across),
    ("Upper border of the region", Way::Along),
    ("Right border of the region", Way::Across),
    ("Lower border of the region", Way::Along),
];
/// Of the picture, that a region is wide and high where keys make it small.
const LEAST_REGION: f32 = 0.02;
/// Frames per second while flying: more would take time from rendering.
const FLIGHT_FPS: f32 = 30.0;

/// What is looked at, and how.
#[derive(Debug, Default)]
pub(super) struct Viewport {
    /// Where the camera is, once the user has moved it.
    navigator: Option<Navigator>,
    /// The look's camera.
    home: Option<Camera>,
    /// Pixels that were asked for.
    size: [u32; 2],
    /// Where the picture is, in points.
    area: Option<Rect>,
    /// The next drag chooses a region.
    pub(super) chooses_region: bool,
    /// Corners of the region, 0 to 1.
    pub(super) region: Option<[f32; 4]>,
    /// Where a region that is being chosen begins.
    region_start: Option<Pos2>,
    /// Where the picture of before ends, 0 to 1, while it is compared with.
    pub(super) split: Option<f32>,
    is_splitting: bool,
    is_flying: bool,
    walk: Option<Walk>,
    /// A light that the next click places.
    pub(super) placing: Option<(String, Placing)>,
    /// A material that was dropped, until it is known on what.
    pub(super) dropped: Option<String>,
}

/// On foot: the eye stays so high above the ground.
#[derive(Debug, Default)]
struct Walk {
    /// Metres; not known before the ground has been found.
    height: Option<f32>,
    /// The ground has been asked for.
    is_asking: bool,
}

impl Viewport {
    /// Whether one walks in place of flying.
    pub(super) fn walks(&self) -> bool {
        self.walk.is_some()
    }

    /// Stands on the ground that was found; gives what is to be looked through then.
    pub(super) fn stand(&mut self, from: Vec3, below: Option<f32>) -> Option<Camera> {
        let walk = self.walk.as_mut()?;
        walk.is_asking = false;
        // Over an abyss it goes on as it was.
        let below = below?;
        let height = *walk.height.get_or_insert(below);
        let eye = self.now()?.eye();
        let rise = height - below + from.y - eye.y;
        // Nobody climbs walls, nor steps off roofs.
        let is_step = (1e-4..=0.75 * height.max(0.01)).contains(&rise.abs());
        is_step.then(|| self.moved(|navigator| navigator.rise(rise)))?
    }

    pub(super) fn scene_changed(&mut self, scene: &SceneFacts) {
        self.home.clone_from(&scene.look_camera);
    }

    /// The camera that is looked through, with what it turns around.
    pub(super) fn now(&self) -> Option<Navigator> {
        let home = || self.home.clone().map(Navigator::new);
        self.navigator.clone().or_else(home)
    }

    /// Whether the camera isn't that of the look.
    pub(super) fn has_own_view(&self) -> bool {
        self.navigator.is_some()
    }

    /// Looks through the look's camera again.
    pub(super) fn go_home(&mut self) {
        self.navigator = None;
    }

    /// Pixels of the picture while nothing moves.
    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Changes the camera, if there is one: what is to be looked through now.
    pub(super) fn moved(&mut self, change: impl FnOnce(&mut Navigator)) -> Option<Camera> {
        let mut navigator = self.now()?;
        change(&mut navigator);
        let camera = navigator.camera().clone();
        self.navigator = Some(navigator);
        Some(camera)
    }

    pub(super) fn focus(&mut self, depth: f32) -> Option<Camera> {
        self.moved(|navigator| {
            navigator.set_distance(depth);
            navigator.camera_mut().focus_distance = depth;
        })
    }
}

impl Viewer {
    pub(super) fn viewport(&mut self, ui: &mut Ui) {
        let rect = ui.available_rect_before_wrap();
        self.viewport.area = Some(rect);
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let label = || egui::WidgetInfo::labeled(egui::Role::Image, true, "Viewport");
        response.widget_info(label);
        self.ask_for_size(ui, rect);
        self.paint(ui, rect);
        self.borders_by_keys(ui, rect);
        if self.split_pointer(ui, rect, &response) {
            return;
        }
        if self.viewport.chooses_region {
            self.choose_region(ui, rect, &response);
            return;
        }
        if let Some(material) = response.dnd_release_payload::<DraggedMaterial>()
            && let Some(at) = ui.input(|input| input.pointer.latest_pos())
        {
            self.viewport.dropped = Some(material.0.clone());
            let [x, y] = place(rect, at);
            let at = glam::Vec2::new(x, y);
            self.link.send(Command::Pick(at, PickPurpose::Drop));
        }
        let view = self.navigate(ui, rect, &response);
        self.send_view(view);
        if response.clicked() {
            response.request_focus();
        }
        // By the pointer it has the keyboard as long as that is there: elsewhere keys are for what lies below.
        let is_moving = ui.input(|input| input.pointer.delta() != Vec2::ZERO);
        if is_moving && !response.contains_pointer() && !keyboard_is_used(ui.ctx()) {
            response.surrender_focus();
        }
        let view = self.navigate_by_keys(ui, &response);
        self.send_view(view);
        // By Enter it is clicked in its middle.
        let clicked = response.interact_pointer_pos().unwrap_or(rect.center());
        if let Some(at) = Some(clicked).filter(|_| response.clicked()) {
            let is_focus = ui.input(|input| input.modifiers.command);
            let purpose = match (&self.viewport.placing, is_focus) {
                (Some(_), _) => PickPurpose::Light,
                (None, true) => PickPurpose::Focus,
                (None, false) => PickPurpose::Material,
            };
            let [x, y] = place(rect, at);
            let at = glam::Vec2::new(x, y);
            self.link.send(Command::Pick(at, purpose));
        }
    }

    fn ask_for_size(&mut self, ui: &Ui, rect: Rect) {
        let coarseness = self.preferences.coarseness.clamp(1, 8) as f32;
        let pixels = rect.size() * ui.ctx().pixels_per_point() / coarseness;
        let size = [pixels.x, pixels.y].map(|side| (side.round() as u32).max(1));
        if size != self.viewport.size {
            self.viewport.size = size;
            self.link.send(Command::Size(size));
        }
    }

    fn paint(&self, ui: &Ui, rect: Rect) {
        let painter = ui.painter_at(rect);
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        match self.picture {
            Some(picture) => {
                let mut painter = painter.clone();
                if let (Some(beside), Some(region)) = (picture.beside, self.viewport.region) {
                    painter.image(beside, rect, whole, Color32::WHITE);
                    painter.set_clip_rect(corners(rect, region));
                }
                match &self.drawn {
                    Some(drawn) => painter.add(drawn.shape(rect)),
                    None => painter.image(picture.now, rect, whole, Color32::WHITE),
                };
                painter.set_clip_rect(rect);
                if let (Some(split), Some(before)) = (self.viewport.split, picture.before) {
                    paint_before(&painter, rect, split, before);
                }
            }
            None => {
                let is_empty = self.scene.files.scene.as_os_str().is_empty();
                let is_refused = self.status.refused.is_some();
                let text = match (self.status.is_loading, is_refused, is_empty) {
                    (true, _, _) => "Reading the scene ...",
                    // What is wrong lies over it.
                    (false, true, _) => "",
                    (false, false, true) => "Drop a glTF file here",
                    (false, false, false) => "Rendering ...",
                };
                let (font, color) = (
                    egui::FontId::proportional(18.0),
                    ui.visuals().weak_text_color(),
                );
                painter.text(rect.center(), Align2::CENTER_CENTER, text, font, color);
            }
        }
        if let Some((light, placing)) = &self.viewport.placing {
            let text = match placing {
                Placing::Aim => format!("click on what {light} is to shine at, or press Esc"),
                Placing::InFront => {
                    format!("click on what {light} is to stand in front of, or press Esc")
                }
            };
            let at = rect.center_top() + Vec2::new(0.0, 10.0);
            note(&painter, at, Align2::CENTER_TOP, &text);
        }
        if let Some(region) = self.viewport.region {
            let region = corners(rect, region);
            let stroke = Stroke::new(1.0, Color32::from_rgb(255, 200, 60));
            painter.rect_stroke(region, 0.0, stroke, StrokeKind::Outside);
        }
        let legend = match self.display.channel {
            Channel::Error => {
                "relative error: blue 0.1 %, cyan 0.6 %, green 3 %, yellow 18 %, red 100 %"
            }
            Channel::Samples => "samples: blue none, green half, red the most",
            Channel::Radiance if self.mixes_unseen() => "lights are mixed (L)",
            _ => return,
        };
        note(
            &painter,
            rect.left_top() + Vec2::splat(10.0),
            Align2::LEFT_TOP,
            legend,
        );
    }

    /// The border between both pictures. True while it has the pointer.
    fn split_pointer(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) -> bool {
        let Some(split) = self.viewport.split else {
            self.viewport.is_splitting = false;
            return false;
        };
        let border = egui::lerp(rect.x_range(), split);
        let is_near = |at: Pos2| (at.x - border).abs() <= GRIP;
        if response.drag_started_by(PointerButton::Primary) {
            let start = ui.input(|input| input.pointer.press_origin());
            self.viewport.is_splitting = start.is_some_and(is_near);
        }
        let is_taken = self.viewport.is_splitting && response.dragged();
        if response.drag_stopped() {
            self.viewport.is_splitting = false;
        }
        if let Some(at) = response.interact_pointer_pos().filter(|_| is_taken) {
            self.viewport.split = Some(place(rect, at)[0]);
        }
        if is_taken || response.hover_pos().is_some_and(is_near) {
            ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
        }
        is_taken
    }

    /// Moves what lies between pictures, and what is around the region, as the keys say.
    fn borders_by_keys(&mut self, ui: &Ui, rect: Rect) {
        if let Some(split) = self.viewport.split {
            let line = corners(rect, [split, 0.0, split, 1.0]).expand2(Vec2::new(GRIP, 0.0));
            let (name, within) = ("Border of Compare", (split, 0.0..=1.0));
            let moved = self
                .borders
                .line(ui, name, Way::Across, (rect, line), within);
            self.viewport.split = moved.or(self.viewport.split);
        }
        let Some(mut region) = self.viewport.region else {
            return;
        };
        // While it is drawn, it is the pointer's.
        if self.viewport.region_start.is_some() {
            return;
        }
        let mut has_moved = false;
        for (side, (name, way)) in REGION.into_iter().enumerate() {
            let mut line = region;
            line[(side + 2) % 4] = region[side];
            let line = corners(rect, line).expand(0.5 * GRIP);
            // A region has an extent.
            let range = match side {
                0 | 1 => 0.0..=region[side + 2] - LEAST_REGION,
                _ => region[side - 2] + LEAST_REGION..=1.0,
            };
            let within = (region[side], range);
            if let Some(to) = self.borders.line(ui, name, way, (rect, line), within) {
                region[side] = to;
                has_moved = true;
            }
        }
        if has_moved {
            self.viewport.region = Some(region);
            self.link.send(Command::Region(self.viewport.region));
        }
    }

    fn choose_region(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) {
        ui.ctx().set_cursor_icon(egui::CursorIcon::Crosshair);
        // By Enter it is in the middle, and its borders are moved from there.
        if response.clicked() && response.interact_pointer_pos().is_none() {
            self.viewport.region = Some([0.25, 0.25, 0.75, 0.75]);
            self.viewport.chooses_region = false;
            self.link.send(Command::Region(self.viewport.region));
            Borders::focus(ui, REGION[0].0);
            return;
        }
        if response.drag_started() {
            self.viewport.region_start = ui.input(|input| input.pointer.press_origin());
        }
        let Some(start) = self.viewport.region_start else {
            return;
        };
        if let Some(at) = response.interact_pointer_pos() {
            let ([x0, y0], [x1, y1]) = (place(rect, start), place(rect, at));
            let corners = [x0.min(x1), y0.min(y1), x0.max(x1), y0.max(y1)];
            self.viewport.region = Some(corners);
        }
        if response.drag_stopped() {
            self.viewport.region_start = None;
            self.viewport.chooses_region = false;
            self.link.send(Command::Region(self.viewport.region));
        }
    }

    /// Moves the camera as the pointer and the keys say.
    fn navigate(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) -> Option<Camera> {
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
    fn navigate_by_keys(&mut self, ui: &Ui, response: &egui::Response) -> Option<Camera> {
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
}

impl Viewer {
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

/// A region of the picture in points.
fn corners(rect: Rect, [left, top, right, bottom]: [f32; 4]) -> Rect {
    let at = |x: f32, y: f32| rect.min + Vec2::new(x, y) * rect.size();
    Rect::from_two_pos(at(left, top), at(right, bottom))
}

fn paint_before(painter: &egui::Painter, rect: Rect, split: f32, before: egui::TextureId) {
    let border = egui::lerp(rect.x_range(), split);
    let part = Rect::from_min_max(pos2(0.0, 0.0), pos2(split, 1.0));
    painter.image(before, rect.with_max_x(border), part, Color32::WHITE);
    painter.vline(border, rect.y_range(), Stroke::new(2.0, Color32::WHITE));
    let top = rect.top() + 10.0;
    note(
        painter,
        pos2(border - 10.0, top),
        Align2::RIGHT_TOP,
        "before",
    );
    note(painter, pos2(border + 10.0, top), Align2::LEFT_TOP, "now");
}

/// A word on the picture, which may be of any colour.
fn note(painter: &egui::Painter, at: Pos2, align: Align2, text: &str) {
    let font = egui::FontId::proportional(13.0);
    let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::WHITE);
    let place = align.anchor_size(at, galley.size());
    painter.rect_filled(place.expand(4.0), 3.0, Color32::from_black_alpha(170));
    painter.galley(place.min, galley, Color32::WHITE);
}

/// A point of the viewport as 0 to 1 from its upper left corner.
fn place(rect: Rect, at: Pos2) -> [f32; 2] {
    let place = (at - rect.min) / rect.size();
    [place.x, place.y].map(|x| x.clamp(0.0, 1.0))
}
