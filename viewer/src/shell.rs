//! The window around [`Viewer`](crate::viewer::Viewer). Where its device is that of the render, the picture is shown without being copied; what the
//! processor renders by itself is brought to the device that draws.

mod app;

use std::panic::AssertUnwindSafe;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use device::{Device, DeviceChoice};
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupExisting};
use egui::ViewportBuilder;
use engine::scene::view::ViewChoice;

use crate::figures::Figures;
use crate::host::Host;
use crate::link::{Command, Denoise, Files, Link};
use crate::thread::{RenderOptions, RenderThread};

use app::Shell;

/// Points of a window that is opened for the first time.
const SIZE: [f32; 2] = [1280.0, 800.0];

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
