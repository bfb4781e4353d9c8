//! What is done with each frame of the window: the picture is taken, the viewer shown, and what was asked for is noted.

use std::sync::Arc;
use std::time::{Duration, Instant};

use device::Device;
use egui::{Ui, ViewportCommand};
use patina_panels::Previews;

use crate::appearance;
use crate::canvas::Canvas;
use crate::figures::Frame;
use crate::file_dialogs::SystemDialogs;
use crate::glyphs::Glyphs;
use crate::link::{Command, Denoise, DenoiserState};
use crate::screen::Screen;
use crate::viewer::{Preferences, Viewer};

use super::{LOST, Parts, Taken, WindowOptions, WindowPicture, lock};

/// Key of what is kept between starts.
const PREFERENCES: &str = "preferences";

/// What the driver refused to draw is drawn again after so long: by then a window has the size that it says it has.
const DRAWN_AGAIN: Duration = Duration::from_millis(30);
/// Frames of the window come no more often where the processor draws them that renders, too: 40 a second are enough to the eye.
const FRAME: Duration = Duration::from_millis(25);
pub(super) struct Shell {
    parts: Parts,
    viewer: Viewer,
    screen: Screen,
    glyphs: Glyphs,
    picture_at_spp: Option<u32>,
    /// That picture is to have no noise.
    waits_for_denoiser: bool,
    /// The picture has been asked for.
    is_taking: bool,
    /// The render has been told that the window can't be drawn any more.
    is_abandoned: bool,
    figures_since: Option<Instant>,
    /// When the last frame began.
    drawn: Option<Instant>,
}

impl Shell {
    pub(super) fn new(
        context: &eframe::CreationContext<'_>,
        parts: Parts,
        options: WindowOptions,
    ) -> Self {
        appearance::apply(&context.egui_ctx);
        // A GPU draws egui's own way as fast.
        let is_software = parts.devices.window.traits().shares_the_processor;
        let state = context.wgpu_render_state.as_ref();
        if let Some(canvas) = state.filter(|_| is_software).and_then(Canvas::new) {
            context.egui_ctx.add_plugin(canvas);
        }
        let storage = context.storage.filter(|_| options.picture_at_spp.is_none());
        let preferences: Preferences = storage
            .and_then(|storage| eframe::get_value(storage, PREFERENCES))
            .unwrap_or_default();
        let last = || {
            let files = preferences.files.clone();
            files.filter(|files| files.scene.exists())
        };
        if options.files.is_none()
            && let Some(files) = last()
        {
            parts.link.send(Command::Open(files));
        }
        // While a window is resized its surface may be refused: that is drawn again, and no failure of the render.
        let ctx = context.egui_ctx.clone();
        if let Some(driver) = parts.devices.window.gpu() {
            driver.draw_here(move |_| ctx.request_repaint_after(DRAWN_AGAIN));
        }
        let mut viewer = Viewer::new(parts.link.clone(), preferences, options.display);
        if let Some(denoise) = options.denoise {
            viewer.set_denoise(denoise);
        }
        // A device of their own, so that they don't keep the render waiting.
        let choice = options.preview_device;
        let open = move || Device::open(&choice);
        viewer.set_file_dialogs(Arc::new(SystemDialogs::over(context)));
        viewer.set_previews(Previews::start(&context.egui_ctx, open));
        Self {
            parts,
            viewer,
            screen: Screen::new(context.wgpu_render_state.as_ref()),
            glyphs: Glyphs::of_system(&context.egui_ctx),
            picture_at_spp: options.picture_at_spp,
            waits_for_denoiser: options.denoise == Some(Denoise::Always),
            is_taking: false,
            is_abandoned: false,
            figures_since: options.figures_since,
            drawn: None,
        }
    }

    /// Leaves the processor to the render for a while, as the wait for a screen's next picture would. What comes meanwhile is heard
    /// together.
    fn rest(&mut self, ui: &Ui) {
        let is_shared = self.parts.devices.window.traits().shares_the_processor;
        // A frame may be laid out more than once.
        if !is_shared || ui.ctx().current_pass_index() > 0 {
            return;
        }
        if let Some(drawn) = self.drawn {
            std::thread::sleep(FRAME.saturating_sub(drawn.elapsed()));
        }
        self.drawn = Some(Instant::now());
    }

    /// Shows the picture that is on the board by now.
    fn take_picture(&mut self, frame: &eframe::Frame) {
        let Some(state) = frame.wgpu_render_state() else {
            return;
        };
        let shown = match &self.parts.link.board().shown {
            Some(shown) if self.screen.is_new(shown) => shown.clone(),
            _ => return,
        };
        self.screen.show(&shown, state, &mut self.viewer);
    }

    /// Closes the window where the program is to end: what was not saved is kept by then.
    fn end_if_asked(&self, ui: &Ui) {
        if self.viewer.status().is_ending {
            ui.ctx().send_viewport_cmd(ViewportCommand::Close);
        }
    }

    /// Without its device the window can show nothing, not even that: it closes, and who opened it tells why.
    fn end_if_lost(&mut self, ui: &Ui) {
        // A render on another device doesn't notice by itself.
        if self.parts.devices.are_two() && !self.is_abandoned && self.parts.devices.window.is_lost()
        {
            self.is_abandoned = true;
            self.parts.link.send(Command::Abandon(LOST.to_owned()));
        }
        if let Some(why) = self.viewer.status().fatal.as_ref()
            && self.parts.devices.window.is_lost()
        {
            lock(&self.parts.lost).get_or_insert_with(|| why.clone());
            ui.ctx().send_viewport_cmd(ViewportCommand::Close);
        }
    }

    fn note_frame(&self, ui: &Ui) {
        let Some(start) = self.figures_since else {
            return;
        };
        let status = self.viewer.status();
        let frame = Frame {
            at: start.elapsed().as_secs_f64(),
            has_picture: self.viewer.picture.is_some(),
            answered: status.answered,
            latency: status.latency,
            coarseness: self.viewer.coarseness(),
            is_whole: status.is_whole,
            is_held: ui.input(|input| input.pointer.any_down()),
        };
        let mut taken = lock(&self.parts.taken);
        taken.figures.get_or_insert_default().note(frame);
    }

    /// Pictures the window when it is time, and closes it.
    fn take_screenshot(&mut self, ui: &Ui) {
        let Some(spp) = self.picture_at_spp else {
            return;
        };
        if lock(&self.parts.taken).picture.is_some() {
            ui.ctx().send_viewport_cmd(ViewportCommand::Close);
            return;
        }
        let status = self.viewer.status();
        let has_samples = |spp_there: f64| spp_there >= f64::from(spp);
        let is_clean = !self.waits_for_denoiser
            || status.denoised.is_some_and(has_samples)
            || matches!(status.denoiser, DenoiserState::Absent(_));
        let is_read = !self.glyphs.is_looking();
        let is_finished = status.is_whole && has_samples(status.spp) && is_clean && is_read;
        let is_ready = is_finished || status.fatal.is_some() || status.refused.is_some();
        if is_ready && !self.is_taking {
            self.is_taking = true;
            let (taken, ctx) = (Taken::clone(&self.parts.taken), ui.ctx().clone());
            let take = move |image: Arc<egui::ColorImage>| {
                lock(&taken).picture = Some(WindowPicture {
                    size: image.size.map(|side| side as u32),
                    rgba: image
                        .pixels
                        .iter()
                        .flat_map(|pixel| pixel.to_array())
                        .collect(),
                });
                ctx.request_repaint();
            };
            let callback = egui::ScreenshotCallback::new(take);
            ui.ctx()
                .send_viewport_cmd(ViewportCommand::Screenshot(callback));
        }
    }
}

impl eframe::App for Shell {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        self.rest(ui);
        self.take_picture(frame);
        self.viewer.ui(ui);
        self.glyphs.update(ui.ctx());
        self.note_frame(ui);
        self.end_if_lost(ui);
        self.end_if_asked(ui);
        self.take_screenshot(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        if self.picture_at_spp.is_none() {
            eframe::set_value(storage, PREFERENCES, self.viewer.kept());
        }
    }

    fn persist_egui_memory(&self) -> bool {
        self.picture_at_spp.is_none()
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn on_exit(&mut self) {
        if let Some(thread) = lock(&self.parts.thread).take() {
            thread.finish();
        }
    }
}
