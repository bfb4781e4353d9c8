//! The bar of tools on top, and the figures at the bottom.

use std::sync::Arc;

use egui::{
    Button, ComboBox, DragValue, KeyboardShortcut, RichText, Slider, SliderClamping,
    ThemePreference, Ui,
};
use engine::display::{Channel, DisplaySettings};
use engine::scene::view::{MAX_EXPOSURE, ViewTransform};
use patina_panels::{asks_for_menu, number_field};

use crate::link::{Command, Denoise, DenoiserState, FINE, NOISY, Status};

use super::dialogs::Dialog;
use super::shortcuts::{OPEN, SAVE, SAVE_AS, SAVE_PICTURE};
use super::{Viewer, call, name};

/// Textures that are listed.
const EXPENSIVE: usize = 10;

/// Stops of the slider.
const EXPOSURE: std::ops::RangeInclusive<f32> = -10.0..=10.0;
/// Digits behind the point that are shown of them, and what is less than a change of the last one: that is rounding.
const DECIMALS: usize = 2;
const LEAST_CHANGE: f32 = 0.006;

impl Viewer {
    pub(super) fn tools(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            self.file_menu(ui);
            self.camera_menu(ui);
            ui.separator();
            let mut display = self.display;
            display_settings(ui, &mut display);
            self.set_display(display);
            ui.separator();
            self.picture_tools(ui);
            let help = ui.button("?").on_hover_text("keyboard and mouse (?)");
            if help.clicked() {
                self.lists_shortcuts ^= true;
            }
        });
    }

    fn file_menu(&mut self, ui: &mut Ui) {
        ui.menu_button("File", |ui| {
            if entry(ui, "Save look", &SAVE) {
                self.save();
            }
            if entry(ui, "Save look as ...", &SAVE_AS) {
                self.dialog = Some(Dialog::save_as(&self.scene.files));
            }
            if entry(ui, "Save picture ...", &SAVE_PICTURE) {
                self.ask_for_picture();
            }
            ui.separator();
            if entry(ui, "Open ...", &OPEN) {
                self.dialog = Some(Dialog::open(&self.scene.files));
            }
            self.recent_menu(ui);
            ui.separator();
            ui.menu_button("Colours", |ui| {
                for (theme, text) in [
                    (ThemePreference::System, "As the system"),
                    (ThemePreference::Dark, "Dark"),
                    (ThemePreference::Light, "Light"),
                ] {
                    ui.radio_value(&mut self.preferences.theme, theme, text);
                }
            });
        });
    }

    /// What has been shown. What isn't there any more, or not now, can't be clicked.
    fn recent_menu(&mut self, ui: &mut Ui) {
        let list = Arc::clone(&self.link.board().recent);
        ui.add_enabled_ui(!list.is_empty(), |ui| {
            ui.menu_button("Open recent", |ui| {
                for files in list.iter() {
                    let look = files.look.as_ref();
                    let text = match look {
                        Some(look) => format!("{} with {}", name(&files.scene), name(look)),
                        None => name(&files.scene),
                    };
                    let is_there = look
                        .into_iter()
                        .chain([&files.scene])
                        .all(|path| path.exists());
                    let entry = ui.add_enabled(is_there, egui::Button::new(text));
                    let whole = files.scene.display().to_string();
                    let entry = entry.on_hover_text(&whole);
                    if entry
                        .on_disabled_hover_text(format!("{whole} is not there"))
                        .clicked()
                    {
                        self.open(files.clone());
                        ui.close();
                    }
                }
            });
        });
    }

    fn picture_tools(&mut self, ui: &mut Ui) {
        let mut is_paused = self.status.is_paused;
        let pause = ui.toggle_value(&mut is_paused, "Pause");
        if pause.on_hover_text("render no more for now (P)").changed() {
            self.link.send(Command::Pause(is_paused));
        }
        let mut has_region = self.viewport.region.is_some() || self.viewport.chooses_region;
        let region = ui.toggle_value(&mut has_region, "Region");
        let hint = "drag a rectangle: only that is rendered (R)";
        if region.on_hover_text(hint).changed() {
            self.toggle_region();
        }
        let mut is_compared = self.viewport.split.is_some();
        let compare = ui.toggle_value(&mut is_compared, "Compare");
        let hint = "keep this picture beside what comes (C)";
        if compare.on_hover_text(hint).changed() {
            self.toggle_compare();
        }
        self.mix_tool(ui);
        self.denoise_tool(ui);
        let coarseness = self.preferences.coarseness.max(1);
        let choices = ComboBox::from_id_salt("coarseness")
            .selected_text(format!("1:{coarseness}"))
            .width(52.0);
        let shown = choices.show_ui(ui, |ui| {
            for choice in [1, 2, 4] {
                let value = &mut self.preferences.coarseness;
                ui.selectable_value(value, choice, format!("1:{choice}"));
            }
        });
        call(&shown.response, "Coarseness");
        let hint = "pixels of the picture per pixel of the screen, along a side";
        shown.response.on_hover_text(hint);
    }

    fn denoise_tool(&mut self, ui: &mut Ui) {
        let (is_ready, hint) = match &self.status.denoiser {
            DenoiserState::Ready(title) => {
                // Not in the bar of figures, which keeps its height: another one would begin the picture anew.
                let shown = self.status.denoised.map_or_else(String::new, |spp| {
                    format!("; shown is that of {:.0} spp", spp.floor())
                });
                let [noisy, fine] = [NOISY, FINE].map(|error| 100.0 * error);
                let levels = format!(
                    "with an error from {noisy:.0} %, below which the result is steady, to {fine:.0} %, which isn't seen"
                );
                let when = match self.denoise {
                    Denoise::ByItself => levels,
                    Denoise::Always => format!("whatever the error is; right-click: {levels}"),
                    Denoise::Never => format!("off; right-click: {levels}"),
                };
                let hint = format!("take the noise out, by {title} (N)\n{when}{shown}");
                (true, hint)
            }
            DenoiserState::Unknown => (false, "looking for Open Image Denoise ...".to_owned()),
            DenoiserState::Absent(why) => (false, why.clone()),
        };
        let is_on = is_ready && self.denoise != Denoise::Never;
        // By itself: within a frame of its own it would break the bar's rows.
        let toggle = ui.add_enabled(is_ready, egui::Button::selectable(is_on, "Denoise"));
        let toggle = toggle.on_hover_text(&hint).on_disabled_hover_text(&hint);
        if toggle.clicked() {
            self.toggle_denoise();
        }
        if toggle.secondary_clicked() {
            self.preferences.denoises = true;
            self.set_denoise(Denoise::ByItself);
        }
    }

    pub(super) fn toggle_denoise(&mut self) {
        if matches!(self.status.denoiser, DenoiserState::Ready(_)) {
            // Who turns it on wants to see it, whatever the noise is.
            let denoise = match self.denoise {
                Denoise::Never => Denoise::Always,
                Denoise::ByItself | Denoise::Always => Denoise::Never,
            };
            self.preferences.denoises = denoise != Denoise::Never;
            self.set_denoise(denoise);
        }
    }

    pub(super) fn toggle_region(&mut self) {
        let had_region = self.viewport.region.take().is_some();
        if had_region {
            self.link.send(Command::Region(None));
        }
        let chooses = !had_region && !self.viewport.chooses_region;
        self.stop_choosing_region();
        self.viewport.chooses_region = chooses;
    }

    pub(super) fn toggle_compare(&mut self) {
        match self.viewport.split.take() {
            Some(_) => self.link.send(Command::KeepBefore(false)),
            None => self.compare(),
        }
    }

    /// Keeps the picture of now beside what comes.
    pub(super) fn compare(&mut self) {
        self.viewport.split.get_or_insert(0.5);
        self.link.send(Command::KeepBefore(true));
    }

    /// Keeps the height that its longest text has needed: another one would make the picture another one, which begins anew.
    pub(super) fn status_bar(&mut self, ui: &mut Ui) {
        let width = ui.available_width();
        if self.figures[0] != width {
            self.figures = [width, 0.0];
        }
        ui.set_min_height(self.figures[1]);
        let height = self.status_line(ui);
        self.figures[1] = self.figures[1].max(height);
    }

    /// The height that it takes.
    fn status_line(&mut self, ui: &mut Ui) -> f32 {
        let line = ui.horizontal_wrapped(|ui| {
            let status = &self.status;
            // First, so that what is counted doesn't move the button from below the pointer.
            if let Some(saving) = &status.saving {
                if ui.small_button("Cancel").clicked() {
                    self.link.send(Command::CancelPicture);
                }
                let (file, done) = (name(&saving.path), saving.spp.floor());
                ui.label(format!("{file}: {done:.0} of {} spp", saving.target));
                ui.separator();
            }
            ui.label(progress(status));
            ui.separator();
            let samples = count(status.samples_per_second);
            let rays = status.mrays_per_second;
            ui.label(format!("{samples} samples/s   {rays:.2} Mrays/s"));
            ui.separator();
            let mebibytes = status.memory as f64 / f64::from(1 << 20);
            ui.label(format!("{mebibytes:.0} MiB"));
            if let Some(latency) = status.latency {
                ui.separator();
                let text = format!("{:.0} ms to a picture", latency * 1e3);
                let hint = "from the last change to its first picture";
                ui.label(text).on_hover_text(hint);
            }
            ui.separator();
            let pipelines = ui.label(format!("{} pipelines", status.pipelines));
            pipelines.on_hover_text(
                "kernels compiled since the start: edits of arguments, links and constants add none",
            );
            let mut shows_times = self.preferences.shows_times;
            let toggle = ui.toggle_value(&mut shows_times, "Times");
            let hint = "how long each pass and each texture takes";
            if toggle.on_hover_text(hint).changed() {
                self.preferences.shows_times = shows_times;
                self.link.send(Command::TimePasses(shows_times));
            }
            if !status.doubts.is_empty() {
                ui.separator();
                // In a word, so that the bar keeps its height: another one would begin the picture anew.
                let color = ui.visuals().warn_fg_color;
                let label = ui.label(RichText::new("warning").color(color));
                label.on_hover_text(&status.doubts);
            }
            if !status.warnings.is_empty() {
                ui.separator();
                let color = ui.visuals().warn_fg_color;
                let label = ui.label(RichText::new("about the files").color(color));
                label.on_hover_text(RichText::new(status.warnings.trim_end()).monospace());
            }
            if let Some(material) = &self.material {
                ui.separator();
                ui.label(format!("material: {material}"));
            }
            ui.separator();
            let (title, files) = (self.title(), &self.scene.files);
            let whole = format!("{}\non {}", files.scene.display(), self.status.device);
            ui.label(title).on_hover_text(whole);
        });
        line.response.rect.height()
    }

    /// Has a height of its own: another one would make the picture another one, which begins anew.
    pub(super) fn times(&mut self, ui: &mut Ui) {
        egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            ui.horizontal_top(|ui| {
                passes(ui, &self.status);
                ui.separator();
                textures(ui, &self.status);
            });
        });
    }
}

fn display_settings(ui: &mut Ui, display: &mut DisplaySettings) {
    let label = ui.label("Exposure");
    // A copy: what the look says may lie beside the slider, or between its steps, and isn't changed by being shown.
    let mut exposure = display.view.exposure;
    let slider = Slider::new(&mut exposure, EXPOSURE)
        .clamping(SliderClamping::Never)
        .fixed_decimals(DECIMALS)
        .suffix(" EV");
    let response = ui.add(slider).labelled_by(label.id);
    // A number field that is left gives back what it showed.
    let change = (exposure - display.view.exposure).abs();
    if response.changed() && change > LEAST_CHANGE {
        display.view.exposure = exposure.clamp(-MAX_EXPOSURE, MAX_EXPOSURE);
    }
    if response.secondary_clicked() || asks_for_menu(&response) {
        display.view.exposure = 0.0;
    }
    response.on_hover_text("brightness of what is shown; right-click for 0");
    let views = ComboBox::from_id_salt("view transform")
        .selected_text(display.view.transform.label())
        .width(80.0);
    let shown = views.show_ui(ui, |ui| {
        for view in ViewTransform::ALL {
            ui.selectable_value(&mut display.view.transform, view, view.label());
        }
    });
    call(&shown.response, "View transform");
    let hint = "view transform: how radiance becomes what a screen shows";
    shown.response.on_hover_text(hint);
    let channels = ComboBox::from_id_salt("channel")
        .selected_text(display.channel.name())
        .width(80.0);
    let shown = channels.show_ui(ui, |ui| {
        for channel in Channel::ALL {
            ui.selectable_value(&mut display.channel, channel, channel.name());
        }
    });
    call(&shown.response, "Channel");
    shown
        .response
        .on_hover_text("channel: what of the picture is shown");
}

fn progress(status: &Status) -> String {
    let [width, height] = status.size;
    let mut text = format!(
        "{:.0} of {} spp   {width} x {height}",
        status.spp.floor(),
        status.target
    );
    if let Some(error) = status.error {
        text = format!("{text}   error {:.2} %", 100.0 * error);
    }
    for (is_so, what) in [
        (status.is_paused, "paused"),
        (status.is_loading, "reading ..."),
        (status.is_building, "building ..."),
    ] {
        if is_so {
            text = format!("{text}   {what}");
        }
    }
    text
}

fn passes(ui: &mut Ui, status: &Status) {
    if status.passes.is_empty() {
        ui.label("no times of passes yet");
        return;
    }
    let grid = egui::Grid::new("passes").num_columns(4).striped(true);
    grid.show(ui, |ui| {
        for heading in ["pass", "share", "ms", "runs"] {
            ui.label(RichText::new(heading).strong());
        }
        ui.end_row();
        for pass in &status.passes {
            ui.label(&pass.name);
            ui.label(format!("{:.1} %", 100.0 * pass.share));
            let mean = pass.milliseconds / pass.dispatches.max(1) as f64;
            ui.label(format!("{mean:.3}"));
            ui.label(pass.dispatches.to_string());
            ui.end_row();
        }
    });
}

/// The textures that take longest, and the AO tables among them.
fn textures(ui: &mut Ui, status: &Status) {
    let costs = &status.textures;
    if costs.list.is_empty() {
        let text = match costs.is_done {
            true => "nothing in sight has a texture of the look",
            false => "no times of textures yet",
        };
        ui.label(text);
        return;
    }
    let [width, height] = status.size;
    let pixels = f64::from(width) * f64::from(height);
    let grid = egui::Grid::new("textures").num_columns(5).striped(true);
    let shown = grid.show(ui, |ui| {
        for heading in [
            "node",
            "texture",
            "ms per sample",
            "runs per pixel",
            "ns per run",
        ] {
            ui.label(RichText::new(heading).strong());
        }
        ui.end_row();
        for cost in costs.list.iter().take(EXPENSIVE) {
            ui.label(&cost.name);
            ui.label(cost.texture.as_deref().unwrap_or("ambient occlusion"));
            ui.label(format!("{:.2}", cost.per_sample() * pixels * 1e-6));
            ui.label(format!("{:.2}", cost.runs_per_pixel));
            ui.label(format!("{:.0}", cost.nanoseconds));
            ui.end_row();
        }
    });
    let hint = "each alone, at what the camera sees first; light that is scattered costs the same again, bounce by bounce";
    shown.response.on_hover_text(hint);
}

/// An entry of a menu that a key chooses as well; whether it was clicked.
fn entry(ui: &mut Ui, text: &str, key: &KeyboardShortcut) -> bool {
    let button = Button::new(text).shortcut_text(ui.ctx().format_shortcut(key));
    let response = ui.add(button);
    // It is called by its own text alone.
    call(&response, text);
    response.clicked()
}

/// With three digits and a unit of thousands.
fn count(number: f64) -> String {
    match number {
        n if n >= 1e9 => format!("{:.2} G", n * 1e-9),
        n if n >= 1e6 => format!("{:.2} M", n * 1e-6),
        n if n >= 1e3 => format!("{:.1} k", n * 1e-3),
        n => format!("{n:.0}"),
    }
}

/// A number from `least` on that is dragged or written, in its own unit; whether it has been.
pub(super) fn dragged(
    ui: &mut Ui,
    text: &str,
    value: &mut f32,
    least: f32,
    speed: f32,
    suffix: &str,
) -> bool {
    let label = ui.label(text);
    let drag = DragValue::new(value)
        .speed(speed)
        .range(least..=f32::MAX)
        .clamp_existing_to_range(false)
        .suffix(suffix);
    number_field(ui, drag).labelled_by(label.id).changed()
}
