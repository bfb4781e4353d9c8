//! Windows that ask for a file.

use std::path::{Path, PathBuf};

use egui::text::{CCursor, CCursorRange};
use egui::{Id, Key, Modal, Response, Ui};

use engine::film::MAX_SIDE;
use engine::scene::import::FORMATS;
use engine::scene::view::{View, ViewTransform};

use patina_panels::{Browser, FileRequest, Purpose};

use crate::link::{Command, Denoise, DenoiserState, Files, PictureOrder, is_radiance};

use super::{Viewer, call, name};

/// Of each pixel of a picture that is saved: nobody waits for more.
const MOST_SAMPLES: u32 = 1 << 20;

/// A file that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dialog {
    what: What,
    path: String,
    look: String,
    picture: Picture,
    /// The scene and the look that are shown.
    shown: [String; 2],
    /// Why the system has no dialog to choose the file in.
    refusal: Option<String>,
    /// It has just been opened: the path gets the keyboard.
    is_new: bool,
}

/// What is wanted of a picture.
#[derive(Debug, Clone, PartialEq, Default)]
struct Picture {
    size: [u32; 2],
    spp: u32,
    layers: bool,
    denoised: bool,
    /// Why it can't be.
    no_denoiser: Option<String>,
    view: View,
    /// The lights of what is shown are mixed.
    is_mixed: bool,
}

/// What people call the files of looks.
const LOOKS: &str = "Looks";
/// How names of pictures end that can be written.
const PICTURES: [&str; 4] = ["png", "jpg", "jpeg", "exr"];
/// Points of a button that opens the system's dialog.
const BROWSE: f32 = 76.0;

/// A picture that is saved has so many samples of each pixel, unless there are more already, or others are asked for.
const SAMPLES: u32 = 64;

#[derive(Debug, Clone, Copy, PartialEq)]
enum What {
    Look,
    Picture,
    Scene,
}

impl What {
    fn name(self) -> &'static str {
        match self {
            Self::Look => "the file of the look",
            Self::Picture => "the file of the picture",
            Self::Scene => "the scene",
        }
    }
}

impl Dialog {
    fn new(what: What, path: &Path, look: Option<&Path>) -> Self {
        let text = |path: &Path| path.display().to_string();
        let (path, look) = (text(path), look.map(text).unwrap_or_default());
        Self {
            what,
            shown: [path.clone(), look.clone()],
            path,
            look,
            refusal: None,
            picture: Picture::default(),
            is_new: true,
        }
    }

    pub(super) fn save_as(files: &Files) -> Self {
        let beside = files.scene.with_extension("look.toml");
        let path = files.look.as_deref().unwrap_or(&beside);
        Self::new(What::Look, path, None)
    }

    fn save_picture(files: &Files, picture: Picture) -> Self {
        let named = files.look.as_deref().unwrap_or(&files.scene);
        let stem = name(named);
        let stem = stem.split('.').next().unwrap_or("picture");
        let path = format!("{stem}.png");
        Self {
            picture,
            ..Self::new(What::Picture, Path::new(&path), None)
        }
    }

    pub(super) fn open(files: &Files) -> Self {
        Self::new(What::Scene, &files.scene, files.look.as_deref())
    }

    fn title(&self) -> &'static str {
        match self.what {
            What::Look => "Save the look as",
            What::Picture => "Save the picture: .png or .jpg as shown, .exr as radiance",
            What::Scene => "Open",
        }
    }

    fn button(&self) -> &'static str {
        match self.what {
            What::Scene => "Open",
            _ => "Save",
        }
    }

    /// What the system is asked for.
    fn request(&self) -> FileRequest {
        let (purpose, kind, endings) = match self.what {
            What::Look => (Purpose::Save, LOOKS, vec!["toml"]),
            What::Picture => (Purpose::Save, "Pictures", PICTURES.to_vec()),
            What::Scene => {
                let endings = FORMATS.iter().flat_map(|format| format.endings);
                (Purpose::Open, "Scenes", endings.copied().collect())
            }
        };
        FileRequest {
            title: self.title().to_owned(),
            purpose,
            kind,
            endings,
            start: PathBuf::from(self.path.trim()),
        }
    }

    fn look_request(&self) -> FileRequest {
        let named = match self.look.trim() {
            "" => self.path.trim(),
            look => look,
        };
        FileRequest {
            title: "Look of the scene".to_owned(),
            purpose: Purpose::Open,
            kind: LOOKS,
            endings: vec!["toml"],
            start: PathBuf::from(named),
        }
    }

    /// A file has been chosen in the system's dialog. Where it is to be written and has no ending, it gets the usual one.
    fn choose(&mut self, mut path: PathBuf) {
        let ending = match self.what {
            What::Look => Some("look.toml"),
            What::Picture => Some("png"),
            What::Scene => None,
        };
        if let (Some(ending), None) = (ending, path.extension()) {
            path.set_extension(ending);
        }
        let [scene, look] = &self.shown;
        if self.what == What::Scene && path != Path::new(scene) && self.look == *look {
            // The former scene's look isn't this one's.
            let own = path.with_extension("look.toml");
            self.look = match own.is_file() {
                true => own.display().to_string(),
                false => String::new(),
            };
        }
        self.path = path.display().to_string();
    }

    fn command(&self) -> Command {
        let path = PathBuf::from(self.path.trim());
        match self.what {
            // How much of others the look has, `save_to` knows.
            What::Look => Command::Save(Some(path), 0),
            What::Picture => Command::SavePicture(PictureOrder {
                path,
                size: self.picture.size,
                spp: self.picture.spp,
                layers: self.picture.layers,
                denoised: self.picture.denoised,
                view: self.picture.view,
            }),
            What::Scene => Command::Open(Files {
                scene: path,
                look: Some(PathBuf::from(self.look.trim())).filter(|p| *p != Path::new("")),
                camera: None,
            }),
        }
    }
}

/// The file, and the look of a scene, each with a button that opens the system's dialog. Whether one of them was ended by Enter.
fn file_fields(ui: &mut Ui, dialog: &mut Dialog, browser: &mut Browser) -> bool {
    // Enter means what has the keyboard; in a button that is the button, and in the frame that opens the dialog another one.
    let ends_by_enter = |field: &Response| {
        field.lost_focus() && field.ctx.input(|input| input.key_pressed(Key::Enter))
    };
    let mut is_done = false;
    let has_system = browser.has_system();
    let width = move |ui: &Ui| match has_system {
        true => ui.available_width() - BROWSE - ui.spacing().item_spacing.x,
        false => f32::INFINITY,
    };
    let label = ui.label("File");
    ui.horizontal(|ui| {
        let edit = egui::TextEdit::singleline(&mut dialog.path).desired_width(width(ui));
        let mut shown = edit.show(ui);
        let path = shown.response.response.clone().labelled_by(label.id);
        is_done |= ends_by_enter(&path);
        if std::mem::take(&mut dialog.is_new) {
            path.request_focus();
            // What is typed takes its place.
            let end = CCursor::new(dialog.path.chars().count());
            let all = CCursorRange::two(CCursor::default(), end);
            shown.state.cursor.set_char_range(Some(all));
            shown.state.store(ui.ctx(), path.id);
        }
        let request = || dialog.request();
        if let Some(chosen) = browser.button(ui, "Browse ...", dialog.what.name(), request) {
            dialog.choose(chosen);
            // The button had the keyboard, and Enter would ask again.
            path.request_focus();
        }
    });
    if dialog.what == What::Scene {
        let label = ui.label("Look (may be empty)");
        ui.horizontal(|ui| {
            let edit = egui::TextEdit::singleline(&mut dialog.look).desired_width(width(ui));
            let look = ui.add(edit).labelled_by(label.id);
            is_done |= ends_by_enter(&look);
            let request = || dialog.look_request();
            if let Some(path) = browser.button(ui, "Browse ...", "the look of the scene", request) {
                dialog.look = path.display().to_string();
                look.request_focus();
            }
        });
    }
    if let Some(why) = browser.take_refusal() {
        dialog.refusal = Some(why);
    }
    if let Some(why) = &dialog.refusal {
        ui.colored_label(ui.visuals().warn_fg_color, why);
    }
    is_done
}

/// How large and how fine a picture is, and how it is shown.
fn picture_fields(ui: &mut Ui, dialog: &mut Dialog) {
    let is_exr = is_radiance(Path::new(dialog.path.trim()));
    let Picture {
        size: [width, height],
        spp,
        layers,
        denoised,
        no_denoiser,
        view,
        is_mixed,
    } = &mut dialog.picture;
    let number = |ui: &mut Ui, text: &str, value: &mut u32, most: u32| {
        let label = ui.label(text);
        let drag = egui::DragValue::new(value).range(1..=most).speed(1.0);
        ui.add(drag).labelled_by(label.id);
    };
    ui.horizontal(|ui| {
        number(ui, "Width", width, MAX_SIDE);
        number(ui, "Height", height, MAX_SIDE);
        number(ui, "Samples per pixel", spp, MOST_SAMPLES);
    });
    ui.add_enabled_ui(no_denoiser.is_none(), |ui| {
        let clean = ui.checkbox(denoised, "Without noise");
        let clean = clean.on_hover_text(
            "as `render --denoise`: .exr keeps the noisy picture as a layer, and other layers as they are",
        );
        clean.on_disabled_hover_text(no_denoiser.as_deref().unwrap_or_default());
    });
    ui.add_enabled_ui(is_exr, |ui| ui.checkbox(layers, "All layers (.exr)"));
    ui.add_enabled_ui(!is_exr, |ui| {
        let views = egui::ComboBox::from_id_salt("view of the picture")
            .selected_text(view.transform.label());
        let shown = views.show_ui(ui, |ui| {
            for transform in ViewTransform::ALL {
                ui.selectable_value(&mut view.transform, transform, transform.label());
            }
        });
        call(&shown.response, "View of the picture");
        ui.label(format!("exposure {:+.2} EV", view.exposure));
    });
    if *is_mixed {
        ui.label(match is_exr {
            true => "Lights are as they are rendered; all layers have their groups apart.",
            false => "Lights are mixed as they are shown.",
        });
    }
    ui.weak("It is finished aside, as it is now: you can go on meanwhile.");
}

impl Viewer {
    /// Asks where the picture is to be saved, and how. As it is seen, unless something else is wanted.
    pub(super) fn ask_for_picture(&mut self) {
        let is_whole = self.status.is_whole;
        let there = if is_whole { self.status.spp as u32 } else { 0 };
        let is_ready = matches!(self.status.denoiser, DenoiserState::Ready(_));
        let no_denoiser = match &self.status.denoiser {
            DenoiserState::Ready(_) => None,
            DenoiserState::Unknown => Some("looking for Open Image Denoise ...".to_owned()),
            DenoiserState::Absent(why) => Some(why.clone()),
        };
        let picture = Picture {
            size: self.viewport.size(),
            spp: there.max(SAMPLES).min(self.status.target.max(1)),
            layers: false,
            denoised: is_ready && self.denoise == Denoise::Always,
            no_denoiser,
            view: self.display.view,
            is_mixed: self.mixes_lights(),
        };
        self.dialog = Some(Dialog::save_picture(&self.scene.files, picture));
    }

    pub(super) fn dialogs(&mut self, ui: &Ui) {
        self.questions(ui);
        let Some(mut dialog) = self.dialog.take() else {
            return;
        };
        let (mut is_done, mut is_cancelled) = (false, false);
        let shown = Modal::new(Id::unique("file dialog")).show(ui.ctx(), |ui| {
            ui.set_width(460.0);
            ui.heading(dialog.title());
            let enter = file_fields(ui, &mut dialog, &mut self.browser);
            if dialog.what == What::Picture {
                picture_fields(ui, &mut dialog);
            }
            let is_there = Path::new(dialog.path.trim()).exists();
            if dialog.what != What::Scene && is_there {
                ui.label("The file is there, and will be replaced.");
            }
            ui.horizontal(|ui| {
                let is_named = !dialog.path.trim().is_empty();
                let button = egui::Button::new(dialog.button());
                is_done = ui.add_enabled(is_named, button).clicked() || is_named && enter;
                is_cancelled = ui.button("Cancel").clicked();
            });
        });
        if is_done || is_cancelled || shown.should_close() {
            self.browser.forget();
        }
        if is_done {
            match dialog.command() {
                Command::Open(files) => self.open(files),
                Command::Save(path, _) => {
                    self.saved_as.clone_from(&path);
                    self.save_to(path);
                }
                command => self.link.send(command),
            }
        } else if is_cancelled || shown.should_close() {
            self.stay();
        } else {
            self.dialog = Some(dialog);
        }
    }
}
