//! All of the window that is no window: state and widgets. It sends commands, reads the board, and knows neither GPU nor
//! window system, so that tests drive it as a user does.

mod bars;
mod borders;
mod dialogs;
mod dropped;
mod lens;
mod look;
mod mix;
mod motion;
mod problems;
mod questions;
mod region;
mod shortcuts;
mod timeline;
mod view;
mod viewport;

use std::sync::Arc;
use std::time::Instant;

use egui::{CentralPanel, Color32, Panel, ThemePreference, Ui};
use engine::display::DisplaySettings;
use engine::scene::view::{View, ViewChoice, ViewTransform};
use patina_panels::{Browser, FileDialogs, show_focus};

use crate::blit::Drawn;
use crate::link::{Command, Denoise, Files, Hit, Link, PickPurpose, Reply, SceneFacts, Status};

use borders::{Borders, Way};
use dialogs::Dialog;
use look::{Editor, Outside};
use mix::LightMixer;
use problems::Problems;
use questions::Questions;
pub use shortcuts::SHORTCUTS;
use timeline::Timeline;
use viewport::Viewport;

/// How long a message stays, seconds.
const MESSAGE: f64 = 6.0;
/// Points of the panel of the look, in which its widgets can be used.
const LEAST_PANEL: f32 = 260.0;
/// The same at first, where it shows lists.
const LIST: f32 = 340.0;
/// The same where it shows a graph, whose cards stand beside each other; at most half of the window.
const GRAPH: f32 = 640.0;
/// Height of the tables of times, in which a line can be read.
const LEAST_TIMES: f32 = 60.0;
/// Heights of a graph below the picture, and of the picture above one, that can be worked with.
const LEAST_GRAPH: f32 = 140.0;
const LEAST_PICTURE: f32 = 120.0;
/// Messages that are kept.
const MESSAGES: usize = 4;

/// What is the same at the next start.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// What was rendered last.
    pub files: Option<Files>,
    /// Stops.
    pub exposure: f32,
    /// By name, see [`ViewTransform::name`].
    pub view: String,
    /// Pixels of the viewport per pixel of the picture.
    pub coarseness: u32,
    /// The picture is shown without its noise where that can be done, once it has so little of it that what is left is steady.
    pub denoises: bool,
    /// A scene without any light is seen in that of a studio.
    pub studio_light: bool,
    /// Of flights and walks, relative to the distance of the point in focus per second.
    pub speed: f32,
    /// Dark, light, or as the system has it.
    pub theme: ThemePreference,
    /// How long passes and textures take is shown.
    pub shows_times: bool,
    /// Materials are shown as a graph.
    pub shows_graph: bool,
    /// The graph is below the picture, and the list beside it.
    pub graph_is_below: bool,
    /// Where the cards of the graph of these files stand.
    pub places: Vec<(String, [f32; 2])>,
}

impl Preferences {
    /// How the picture was shown; a transform that there is no more is the usual one.
    fn view(&self) -> View {
        View {
            exposure: self.exposure,
            white_balance: None,
            transform: ViewTransform::named(&self.view).unwrap_or_default(),
        }
    }
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            files: None,
            exposure: 0.0,
            view: ViewTransform::default().name().to_owned(),
            coarseness: 1,
            denoises: true,
            studio_light: true,
            speed: 1.0,
            theme: ThemePreference::System,
            shows_times: false,
            shows_graph: false,
            graph_is_below: false,
            places: Vec::new(),
        }
    }
}

/// What the picture is called where widgets are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureIds {
    /// What is rendered.
    pub now: egui::TextureId,
    /// What it is compared with.
    pub before: Option<egui::TextureId>,
    /// What lies beside the region, where only that follows changes.
    pub beside: Option<egui::TextureId>,
    /// Pixels of what is rendered.
    pub size: [u32; 2],
}

/// The window's contents.
#[derive(Debug)]
pub struct Viewer {
    link: Link,
    /// What is kept between starts.
    pub preferences: Preferences,
    /// The picture, once there is one.
    pub picture: Option<PictureIds>,
    /// What draws it faster than egui does, if there is such a thing.
    pub drawn: Option<Drawn>,
    display: DisplaySettings,
    /// When the picture is shown without its noise.
    denoise: Denoise,
    /// What the command line says of the view.
    given_view: ViewChoice,
    viewport: Viewport,
    borders: Borders,
    editor: Editor,
    status: Status,
    scene: Arc<SceneFacts>,
    messages: Vec<Message>,
    dialog: Option<Dialog>,
    browser: Browser,
    lists_shortcuts: bool,
    /// A picture that was dropped, as the look names it, until it is known what for.
    picture_to_use: Option<String>,
    mixer: LightMixer,
    questions: Questions,
    timeline: Timeline,
    /// The look is being saved as this file, which is its own from then on.
    saved_as: Option<std::path::PathBuf>,
    /// Of the window.
    shown_title: String,
    problems: Problems,
    /// Material that was clicked.
    material: Option<String>,
    /// Width of the bar of figures, and the greatest height that it has had since it has that, points.
    figures: [f32; 2],
}

#[derive(Debug)]
struct Message {
    text: String,
    is_error: bool,
    until: f64,
}

impl Viewer {
    /// With a line to the render; `view` is what counts more than the look's view and that of the last start.
    pub fn new(link: Link, preferences: Preferences, view: ViewChoice) -> Self {
        let display = DisplaySettings {
            view: view.over(preferences.view()),
            ..DisplaySettings::default()
        };
        link.send(Command::Display(display));
        let denoise = match preferences.denoises {
            true => Denoise::ByItself,
            false => Denoise::Never,
        };
        link.send(Command::Denoise(denoise));
        link.send(Command::StudioLight(preferences.studio_light));
        link.send(Command::TimePasses(preferences.shows_times));
        Self {
            link,
            preferences,
            picture: None,
            drawn: None,
            display,
            denoise,
            given_view: view,
            viewport: Viewport::default(),
            borders: Borders::default(),
            editor: Editor::default(),
            status: Status::default(),
            scene: Arc::default(),
            messages: Vec::new(),
            dialog: None,
            browser: Browser::default(),
            lists_shortcuts: false,
            picture_to_use: None,
            mixer: LightMixer::default(),
            questions: Questions::default(),
            timeline: Timeline::default(),
            saved_as: None,
            shown_title: String::new(),
            problems: Problems::default(),
            material: None,
            figures: [0.0; 2],
        }
    }

    /// Shows the picture without its noise from now on whenever this says, where that can be done.
    pub fn set_denoise(&mut self, denoise: Denoise) {
        self.denoise = denoise;
        self.link.send(Command::Denoise(denoise));
    }

    /// The material that was clicked last.
    pub fn material(&self) -> Option<&str> {
        self.material.as_deref()
    }

    /// Figures as they are shown.
    pub fn status(&self) -> &Status {
        &self.status
    }

    /// Has all that asks for a file ask that system from now on.
    pub fn set_file_dialogs(&mut self, system: Arc<dyn FileDialogs>) {
        self.editor.set_file_dialogs(Arc::clone(&system));
        self.browser.set_system(system);
    }

    /// Pixels of the viewport per pixel of the picture, along a side.
    pub(crate) fn coarseness(&self) -> f64 {
        let [whole, _] = self.viewport.size();
        f64::from(whole) / f64::from(self.status.size[0].max(1))
    }

    /// Something that the window itself has to say.
    pub fn tell(&mut self, text: String, is_error: bool, now: f64) {
        let until = now + MESSAGE * if is_error { 3.0 } else { 1.0 };
        self.messages.retain(|message| message.text != text);
        self.messages.push(Message {
            text,
            is_error,
            until,
        });
        let surplus = self.messages.len().saturating_sub(MESSAGES);
        self.messages.drain(..surplus);
    }

    /// Shows everything, and does what the user does.
    pub fn ui(&mut self, ui: &mut Ui) {
        let now = ui.input(|input| input.time);
        // What was edited since the last frame is no change of the file's.
        self.flush_edits();
        let (is_touched, is_held) = ui.input(|input| {
            let is_held = input.pointer.any_down() || !input.keys_down.is_empty();
            (!input.events.is_empty(), is_held)
        });
        {
            let mut board = self.link.board();
            board.is_held = is_held;
            if is_touched {
                board.touched = Some(Instant::now());
            }
        }
        ui.ctx().set_theme(self.preferences.theme);
        self.read_board(now);
        self.show_view();
        self.borders.take_keys(ui);
        self.take_keys(ui);
        self.take_dropped(ui);
        // The window is cleared with the panels' colour: to fill it twice takes a software driver as long as the rest.
        let bare = egui::Frame::side_top_panel(ui.style()).fill(Color32::TRANSPARENT);
        let top = Panel::top("tools").frame(bare);
        top.show(ui, |ui| self.tools(ui));
        let bottom = Panel::bottom("status").frame(bare);
        bottom.show(ui, |ui| self.status_bar(ui));
        if let Some(end) = self.scene.end {
            let time = Panel::bottom("timeline").frame(bare);
            time.show(ui, |ui| self.timeline(ui, end, now));
        }
        if self.preferences.shows_times {
            self.borders
                .before_panel(ui, "times", Way::Along, LEAST_TIMES);
            let times = Panel::bottom("times").frame(bare).resizable(true);
            let times = times.default_size(190.0).min_size(LEAST_TIMES);
            times.show(ui, |ui| self.times(ui));
            Borders::name_panel(ui, "times", "Border of the times");
        }
        // A graph that is as narrow as a list can't be read: each has a width of its own.
        let (id, width) = match self.editor.shows_graph() && !self.lists_shortcuts {
            true => ("graph", GRAPH.min(0.5 * ui.available_width()).max(LIST)),
            false => ("look", LIST),
        };
        self.borders.before_panel(ui, id, Way::Across, LEAST_PANEL);
        Panel::right(id)
            .frame(bare)
            .resizable(true)
            .default_size(width)
            .min_size(LEAST_PANEL)
            // A window that becomes narrow keeps a part of the picture.
            .max_size((ui.available_width() - LEAST_PICTURE).max(LEAST_PANEL))
            .show(ui, |ui| {
                // Before there is a look, too: a panel is as wide afterwards as what was in it at first.
                ui.set_min_width(ui.available_width());
                match (self.lists_shortcuts, self.mixer.is_open) {
                    (true, _) => self.shortcut_list(ui),
                    (false, true) => self.mix_panel(ui),
                    (false, false) => self.look_panel(ui),
                }
            });
        Borders::name_panel(ui, id, "Border of the panel");
        if self.editor.graph_is_below() {
            let most = ui.available_height() - LEAST_PICTURE;
            let salt = "graph below";
            self.borders.before_panel(ui, salt, Way::Along, LEAST_GRAPH);
            Panel::bottom(salt)
                .frame(bare)
                .resizable(true)
                .default_size(0.4 * ui.available_height())
                .min_size(LEAST_GRAPH)
                .max_size(most.max(LEAST_GRAPH))
                .show(ui, |ui| {
                    ui.set_min_size(ui.available_size());
                    self.graph_panel(ui);
                });
            Borders::name_panel(ui, salt, "Border of the graph");
        }
        CentralPanel::default()
            .frame(egui::Frame::NONE)
            .show(ui, |ui| {
                let picture = ui.available_rect_before_wrap();
                self.viewport(ui);
                self.stand_in_light(ui, picture);
                self.problems(ui, picture);
                self.messages(ui, now, picture);
            });
        self.dialogs(ui);
        self.picture_question(ui);
        self.flush_edits();
        self.send_mix();
        self.show_title(ui);
        self.close(ui);
        show_focus(ui.ctx());
    }

    /// What is rendered, and whether it has edits that are not saved.
    fn title(&self) -> String {
        let files = &self.scene.files;
        let mut title = name(&files.scene);
        if let Some(look) = &files.look {
            title = format!("{title} with {}", name(look));
        }
        if self.has_unsaved_edits() {
            title.push_str(" *");
        }
        title
    }

    fn show_title(&mut self, ui: &Ui) {
        let title = match self.title() {
            nothing if nothing.is_empty() => "Patina".to_owned(),
            title => format!("{title} - Patina"),
        };
        if title != self.shown_title {
            self.shown_title.clone_from(&title);
            ui.ctx()
                .send_viewport_cmd(egui::ViewportCommand::Title(title));
        }
    }

    fn read_board(&mut self, now: f64) {
        let (replies, scene, status, look) = {
            let mut board = self.link.board();
            let replies = std::mem::take(&mut board.replies);
            let scene = Arc::clone(&board.scene);
            (replies, scene, board.status.clone(), board.look.clone())
        };
        self.status = status;
        if !Arc::ptr_eq(&scene, &self.scene) {
            self.scene = scene;
            self.viewport.scene_changed(&self.scene);
            self.follow_saved();
        }
        for reply in replies {
            self.hear(reply, now);
        }
        // What was edited by them is no change of the file's, either.
        self.flush_edits();
        if let Some(look) = look {
            let path = self.scene.files.look.clone().unwrap_or_default();
            match self.editor.read(&look, &path) {
                Some(Outside::Conflict(conflict)) => self.ask_about(Some(conflict)),
                Some(Outside::AsBefore) => {}
                outside => {
                    self.ask_about(None);
                    if outside.is_some() {
                        let text = "another program has changed the look's file: its changes are here, together with yours";
                        self.tell(text.to_owned(), false, now);
                    }
                }
            }
        }
    }

    /// The look has another file from now on, and is the same: what was done counts for that one, now and when it is opened again.
    fn follow_saved(&mut self) {
        let files = &self.scene.files;
        let is_saved = self.saved_as.is_some() && self.saved_as == files.look;
        let files = files.absolute();
        if let Some(last) = self.preferences.files.as_mut().filter(|_| is_saved)
            && last.scene == files.scene
        {
            last.look = files.look;
            self.saved_as = None;
        }
    }

    fn hear(&mut self, reply: Reply, now: f64) {
        match reply {
            Reply::Picked { purpose, hit } => match (purpose, hit) {
                (PickPurpose::Material, Some(hit)) => {
                    self.show_material(&hit.material);
                    self.material = Some(hit.material);
                }
                (PickPurpose::Material, None) => self.material = None,
                (PickPurpose::Focus, Some(Hit { depth, .. })) => {
                    let view = self.viewport.focus(depth);
                    self.send_view(view);
                    self.tell(format!("focus at {depth:.3} m"), false, now);
                }
                (PickPurpose::Focus, None) => {}
                (PickPurpose::Light, hit) => self.place_light(hit.as_ref(), now),
                (PickPurpose::Drop, hit) => self.drop_material(hit, now),
            },
            Reply::Done(text) => self.tell(text, false, now),
            Reply::Failed(text) => self.tell(text, true, now),
            Reply::NotWritten(text) => {
                self.saved_as = None;
                self.stay_if_unsaved();
                self.tell(text, true, now);
            }
            Reply::Ground { from, below } => {
                let view = self.viewport.stand(from, below);
                self.send_view(view);
            }
            Reply::Bounds([low, high]) => {
                let view = self.viewport.moved(|camera| camera.frame(low, high));
                self.send_view(view);
            }
            Reply::Moment(seconds) => self.timeline = Timeline::at(seconds),
            Reply::Opened(files) => {
                self.link.send(Command::HasOpened);
                self.viewport = Viewport::default();
                self.timeline = Timeline::default();
                self.forget_mix();
                self.saved_as = None;
                let last = self.preferences.files.take();
                let is_again = self.document_mut().is_some()
                    && last.as_ref().is_some_and(|last| is_same(last, &files));
                match is_again {
                    true => self.editor.reopen(),
                    false => {
                        self.editor.forget();
                        self.begin_look(last == Some(files.absolute()));
                    }
                }
                self.material = None;
                // Found again from whatever folder the window is opened next.
                self.preferences.files = Some(files.absolute());
            }
        }
    }

    fn send_view(&self, view: Option<engine::scene::Camera>) {
        if let Some(camera) = view {
            self.link.send(Command::View(Some(camera)));
        }
    }
}

/// Whether scene and look are the same files, however they are named.
fn is_same(one: &Files, other: &Files) -> bool {
    let found = |path: &std::path::Path| {
        let absolute = || std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        path.canonicalize().unwrap_or_else(|_| absolute())
    };
    let pair = |files: &Files| (found(&files.scene), files.look.as_deref().map(found));
    pair(one) == pair(other)
}

/// A path for people.
fn name(path: &std::path::Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Gives a list the name by which assistive technology finds it, and so do tests.
fn call(list: &egui::Response, name: &str) {
    call_id(&list.ctx, list.id, name);
}

fn call_id(ctx: &egui::Context, id: egui::Id, name: &str) {
    ctx.accesskit_node_builder(id, |node| node.set_label(name));
}
