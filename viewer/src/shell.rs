//! The window around [`Viewer`]. Where its device is that of the render, the picture is shown without being copied; what the
//! processor renders by itself is brought to the device that draws.

use std::panic::AssertUnwindSafe;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use device::{Device, DeviceChoice};
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupExisting};
use egui::{Ui, ViewportBuilder, ViewportCommand};
use engine::scene::view::ViewChoice;
use patina_panels::Previews;

use crate::appearance;
use crate::canvas::Canvas;
use crate::figures::{Figures, Frame};
use crate::file_dialogs::SystemDialogs;
use crate::glyphs::Glyphs;
use crate::host::Host;
use crate::link::{Command, Denoise, DenoiserState, Files, Link};
use crate::screen::Screen;
use crate::thread::{RenderOptions, RenderThread};
use crate::viewer::{Preferences, Viewer};

/// Key of what is kept between starts.
const PREFERENCES: &str = "preferences";
/// Points of a window that is opened for the first time.
const SIZE: [f32; 2] = [1280.0, 800.0];

/// What the driver refused to draw is drawn again after so long: by then a window has the size that it says it has.
const DRAWN_AGAIN: Duration = Duration::from_millis(30);
/// Frames of the window come no more often where the processor draws them that renders, too: 40 a second are enough to the eye.
const FRAME: Duration = Duration::from_millis(25);
/// Of the device that draws.
const LOST: &str = "the graphics device was lost";
/// How long a render may take to notice that the device is lost.
const FAREWELL: Duration = Duration::from_secs(10);

/// What renders, and what draws the window. Both may be one.
#[derive(Debug, Clone)]
pub struct Devices {
    /// The picture is rendered on this one.
    pub render: Device,
    /// The window is drawn by this one, which has a driver.
    pub window: Device,
}

impl Devices {
    /// The picture has to be brought from one to the other.
    fn are_two(&self) -> bool {
        self.render.gpu().is_none()
    }
}

/// What is opened, and how.
#[derive(Debug, Clone)]
pub struct WindowOptions {
    /// What is rendered; what was rendered last without it.
    pub files: Option<Files>,
    /// How it is rendered.
    pub render: RenderOptions,
    /// Of the previews of nodes.
    pub preview_device: DeviceChoice,
    /// How the picture is shown; what this doesn't say, the look or the last start does.
    pub display: ViewChoice,
    /// When the picture is shown without its noise; as at the last start without it.
    pub denoise: Option<Denoise>,
    /// The window is pictured and closed, once the render has so many samples per pixel.
    pub picture_at_spp: Option<u32>,
    /// Figures are taken, which count from then.
    pub figures_since: Option<Instant>,
}

/// What a window leaves.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Closed {
    /// A picture of it, if one was asked for and could be taken.
    pub picture: Option<WindowPicture>,
    /// How quickly it followed, if that was asked for.
    pub figures: Option<Figures>,
}

/// A picture of the window.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WindowPicture {
    /// Pixels.
    pub size: [u32; 2],
    /// 8-bit RGBA as it is shown, row 0 on top.
    pub rgba: Vec<u8>,
}

/// Why there is no window, or none any more.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no window system, or none that can be used.
    #[error("cannot open a window: {0}")]
    System(#[from] eframe::Error),
    /// The processor renders by itself, but a window needs a driver to be drawn.
    #[error(
        "a window needs a graphics driver to be drawn, be it one in software (Debian/Ubuntu: `apt install mesa-vulkan-drivers \
         libvulkan1`); `render` and `watch` need none"
    )]
    NoDriver,
    /// The window's device is gone, and nothing can be drawn without it. The text says where edits are that were not saved.
    #[error("{0}")]
    Lost(String),
}

/// Opens a window and returns when it has been closed.
///
/// # Errors
/// There is no window system, or the device that draws was lost.
pub fn run(
    devices: &Devices,
    options: WindowOptions,
    host: Box<dyn Host>,
) -> Result<Closed, WindowError> {
    let window = &devices.window;
    let driver = window.gpu().ok_or(WindowError::NoDriver)?;
    let setup = WgpuSetupExisting {
        instance: driver.instance().clone(),
        adapter: driver.adapter().clone(),
        device: driver.device().clone(),
        queue: driver.queue().clone(),
    };
    let taken = Taken::default();
    let is_screenshot = options.picture_at_spp.is_some();
    let native = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("Patina")
            .with_app_id("patina")
            .with_inner_size(SIZE)
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: WgpuConfiguration {
            wgpu_setup: WgpuSetup::Existing(setup),
            ..WgpuConfiguration::default()
        },
        // They are looked for when one is missing, and nobody waits for them.
        system_font_fallback: false,
        // A screenshot looks the same whatever the last window was.
        persist_window: !is_screenshot,
        // Nobody sees it in flat panels, and a software driver pays for each pixel.
        dithering: !window.traits().shares_the_processor,
        ..eframe::NativeOptions::default()
    };
    let lost = Arc::new(Mutex::new(None));
    // Files are read while the window is opened.
    let seen = Arc::new(OnceLock::<egui::Context>::new());
    let waked = Arc::clone(&seen);
    let wake = Box::new(move || {
        if let Some(ctx) = waked.get() {
            ctx.request_repaint();
        }
    });
    let (render, files) = (devices.render.clone(), options.files.clone());
    let thread = RenderThread::start(render, files, options.render.clone(), host, wake)
        .map_err(|error| eframe::Error::AppCreation(error.into()))?;
    let link = thread.link.clone();
    let running = Arc::new(Mutex::new(Some(thread)));
    let parts = Parts {
        devices: devices.clone(),
        link,
        thread: Arc::clone(&running),
        taken: Taken::clone(&taken),
        lost: Arc::clone(&lost),
    };
    let shown = AssertUnwindSafe(move || {
        eframe::run_native(
            "Patina",
            native,
            Box::new(move |context| {
                let shell = Shell::new(context, parts, options);
                // What there is to see by now is seen.
                let _ = seen.set(context.egui_ctx.clone());
                context.egui_ctx.request_repaint();
                Ok(Box::new(shell))
            }),
        )
    });
    // egui panics where it meets a device that is lost, before or after the render has noticed.
    match std::panic::catch_unwind(shown) {
        Ok(outcome) => {
            // Where no window could be opened, nobody has ended it.
            if let Some(thread) = lock(&running).take() {
                thread.finish();
            }
            outcome?;
        }
        Err(_) if window.is_lost() => {
            let thread = lock(&running).take();
            return Err(WindowError::Lost(
                thread.map_or_else(String::new, |thread| farewell(thread, devices.are_two())),
            ));
        }
        Err(panic) => std::panic::resume_unwind(panic),
    }
    if let Some(why) = lock(&lost).take() {
        return Err(WindowError::Lost(why));
    }
    let closed = std::mem::take(&mut *lock(&taken));
    Ok(closed)
}

/// Waits until the render has noticed that the device is lost, or heard of it where that isn't its own, and has kept the edits:
/// what it says of that.
fn farewell(thread: RenderThread, are_two: bool) -> String {
    let end = Instant::now() + FAREWELL;
    if are_two {
        thread.link.send(Command::Abandon(LOST.to_owned()));
    }
    let why = loop {
        if let Some(why) = thread.link.board().status.fatal.clone() {
            break why;
        }
        if Instant::now() > end {
            return LOST.to_owned();
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    thread.finish();
    why
}

/// What is left, as far as there is something.
type Taken = Arc<Mutex<Closed>>;

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a shell shares with [`run`].
struct Parts {
    devices: Devices,
    link: Link,
    thread: Arc<Mutex<Option<RenderThread>>>,
    taken: Taken,
    /// Why the window has closed by itself.
    lost: Arc<Mutex<Option<String>>>,
}

struct Shell {
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
    fn new(context: &eframe::CreationContext<'_>, parts: Parts, options: WindowOptions) -> Self {
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
        let is_finished = status.is_whole && has_samples(status.spp) && is_clean;
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
