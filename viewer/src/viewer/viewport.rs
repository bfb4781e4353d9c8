//! The picture: where it is, what is drawn on it, and what a click in it is for.

use egui::{Align2, Color32, Pos2, Rect, Sense, Stroke, StrokeKind, Ui, Vec2, pos2};
use engine::display::Channel;
use engine::scene::Camera;
use glam::Vec3;
use patina_panels::{DraggedMaterial, Placing, keyboard_is_used};

use crate::link::{Command, PickPurpose, SceneFacts};
use crate::navigate::Navigator;

use super::Viewer;

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
    pub(super) region_start: Option<Pos2>,
    /// Where the picture of before ends, 0 to 1, while it is compared with.
    pub(super) split: Option<f32>,
    pub(super) is_splitting: bool,
    pub(super) is_flying: bool,
    pub(super) walk: Option<Walk>,
    /// A light that the next click places.
    pub(super) placing: Option<(String, Placing)>,
    /// A material that was dropped, until it is known on what.
    pub(super) dropped: Option<String>,
}

/// On foot: the eye stays so high above the ground.
#[derive(Debug, Default)]
pub(super) struct Walk {
    /// Metres; not known before the ground has been found.
    height: Option<f32>,
    /// The ground has been asked for.
    pub(super) is_asking: bool,
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
}

/// A region of the picture in points.
pub(super) fn corners(rect: Rect, [left, top, right, bottom]: [f32; 4]) -> Rect {
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
pub(super) fn place(rect: Rect, at: Pos2) -> [f32; 2] {
    let place = (at - rect.min) / rect.size();
    [place.x, place.y].map(|x| x.clamp(0.0, 1.0))
}
