//! `patina view`: the window of `patina_viewer`, with this program's files, formats and folders.

pub(crate) mod args;
pub(crate) mod job;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use device::{Device, DeviceChoice, DeviceError, DeviceOptions};
use engine::film::write::{Content, Form};
use patina_viewer::host::{Changes, Finished, Host, OpenDenoiser};
use patina_viewer::link::{Denoise, Files, Waker};
use patina_viewer::shell::{self, Devices, WindowError, WindowOptions};
use patina_viewer::thread::RenderOptions;

use crate::failure::Failure;
use crate::output;
use crate::watch::files::Watcher;
use crate::words::{NATIVE, Output, parse_output};
use crate::{cache, console, interrupt, library, recent};

use job::ViewJob;

/// How often files are looked at that have no events, while the window has nothing to do.
const LOOKED_AT: Duration = Duration::from_secs(1);

/// A window that is to close because a signal has come has so long for it: what was not saved is kept by then.
const CLOSING: Duration = Duration::from_secs(3);

/// Pixels of a picture before the window has said how large it is.
const FIRST_SIZE: [u32; 2] = [640, 360];

/// Opens the window and returns when it has been closed.
///
/// # Errors
/// There is no device or no window system, or a file on the command line isn't there. A signal has ended it, and edits that were not
/// saved are kept.
pub(crate) fn run(job: &ViewJob) -> Result<(), Failure> {
    let start = Instant::now();
    // Said at once rather than in a window.
    for file in job.scene.iter().chain(&job.look) {
        std::fs::metadata(file)
            .map_err(|error| Failure::Failed(format!("cannot read {}: {error}", file.display())))?;
    }
    if let Some((output, _)) = &job.screenshot {
        let read: Vec<_> = job.scene.iter().chain(&job.look).cloned().collect();
        output::check_all(std::slice::from_ref(&output.path), &read)?;
    }
    is_displayed()?;
    if job.denoise {
        crate::denoise::open().map_err(|why| Failure::Failed(format!("--denoise: {why}")))?;
    }
    let host = ProgramHost {
        texture_dirs: job.texture_dirs.clone(),
        watched: None,
        waker: None,
        begun: SystemTime::now(),
        read: Vec::new(),
    };
    library::texture_dirs(&job.texture_dirs, job.look.as_deref())?;
    let folder = cache::folder();
    let devices = devices(&job.device, folder.as_deref())?;
    let files = job.scene.clone().map(|scene| Files {
        scene,
        look: job.look.clone(),
        camera: job.camera.clone(),
    });
    let options = WindowOptions {
        files,
        render: RenderOptions {
            target_spp: job.spp,
            max_depth: job.max_depth,
            seed: job.seed,
            size: FIRST_SIZE,
        },
        preview_device: match devices.render.gpu() {
            // What is known isn't looked for again.
            None if job.device == DeviceChoice::Best => native(),
            _ => job.device.clone(),
        },
        display: job.display,
        denoise: match (job.denoise, &job.screenshot) {
            (true, _) => Some(Denoise::Always),
            // It looks the same whatever is installed, and however long that takes.
            (false, Some(_)) => Some(Denoise::Never),
            (false, None) => None,
        },
        picture_at_spp: job.screenshot.as_ref().map(|(_, spp)| *spp),
        figures_since: job.figures.then_some(start),
    };
    let outcome = shell::run(&devices, options, Box::new(host)).map_err(|error| match error {
        WindowError::System(_) => no_window(&without_places(&error.to_string())),
        WindowError::NoDriver | WindowError::Lost(_) => Failure::because(error),
    });
    // Nothing depends on it but the time of the next start.
    let _ = devices.window.save_cache();
    let closed = outcome?;
    if interrupt::requested() {
        return Err(Failure::Interrupted);
    }
    if let Some(figures) = &closed.figures {
        console::print(figures.to_string().trim_end());
    }
    match (closed.picture, &job.screenshot) {
        (Some(picture), Some((output, _))) => {
            output::write_shown(output, picture.size, &picture.rgba).map_err(Failure::because)?;
            console::print(&format!("wrote {}", output.path.display()));
            Ok(())
        }
        (None, Some(_)) => {
            let why = "the window was closed before it could be pictured";
            Err(Failure::Failed(why.to_owned()))
        }
        (_, None) => Ok(()),
    }
}

/// What renders, and what draws the window: one device, if it has a driver. Where nothing is said, that is a real GPU; without one
/// the processor renders by itself, faster than by a driver in software, which then has nothing to do but to draw the window.
fn devices(choice: &DeviceChoice, cache: Option<&Path>) -> Result<Devices, Failure> {
    let open = |choice: &DeviceChoice| {
        let options = DeviceOptions::new(choice).with_cache(cache);
        Device::open_with(&options).map_err(|error| match error {
            DeviceError::NoAdapter => Failure::because(WindowError::NoDriver),
            error => Failure::because(error),
        })
    };
    if *choice != DeviceChoice::Best {
        let render = open(choice)?;
        let window = match render.gpu() {
            Some(_) => render.clone(),
            None => open(&DeviceChoice::Driver)?,
        };
        return Ok(Devices { render, window });
    }
    // Drivers are looked for once: that takes a tenth of a second.
    let window = open(&DeviceChoice::Driver)?;
    let render = match window.description().is_processor {
        true => open(&native())?,
        false => window.clone(),
    };
    Ok(Devices { render, window })
}

/// The processor without a driver, on the program's threads.
fn native() -> DeviceChoice {
    DeviceChoice::Name(NATIVE.to_owned())
}

/// Whether there is something to open a window on, as far as the system says so beforehand.
fn is_displayed() -> Result<(), Failure> {
    // What Wayland and X11 find their display by; other systems have one or fail when it is opened.
    const VARIABLES: [&str; 3] = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"];
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let needs_them = cfg!(all(
        unix,
        not(target_os = "macos"),
        not(target_os = "android")
    ));
    match !needs_them || VARIABLES.into_iter().any(is_set) {
        true => Ok(()),
        false => Err(no_window(
            "cannot open a window: there is no display (neither WAYLAND_DISPLAY nor DISPLAY is set)",
        )),
    }
}

fn no_window(why: &str) -> Failure {
    Failure::Failed(format!(
        "{why}; `patina render` and `patina watch` need no display"
    ))
}

/// A library's text without the source files that it names, which nobody has.
fn without_places(text: &str) -> String {
    const HEAD: &str = "os error at ";
    let mut rest = text;
    let mut kept = String::new();
    while let Some(at) = rest.find(HEAD) {
        kept.push_str(&rest[..at]);
        let place = &rest[at + HEAD.len()..];
        // `FILE.rs:LINE: what it is`
        let after = place.find(".rs:").and_then(|end| {
            let number = &place[end + 4..];
            let digits = number.find(|c: char| !c.is_ascii_digit())?;
            number[digits..].strip_prefix(": ")
        });
        match after {
            Some(after) => rest = after,
            None => {
                kept.push_str(HEAD);
                rest = place;
            }
        }
    }
    kept + rest
}

/// What the window wants of this program.
struct ProgramHost {
    /// Folders named on the command line.
    texture_dirs: Vec<PathBuf>,
    watched: Option<Watched>,
    /// Wakes the window's render.
    waker: Option<Waker>,
    /// When it was started: all that is shown has been read since.
    begun: SystemTime,
    /// What is shown: no picture is written over it.
    read: Vec<PathBuf>,
}

struct Watched {
    watcher: Watcher,
    textures: Vec<PathBuf>,
}

impl ProgramHost {
    /// What a picture is written to, unless that is shown.
    fn output(&self, path: &Path) -> Result<Output, String> {
        let output = parse_output(path.to_owned()).map_err(|error| error.to_string())?;
        output::refuse_overwriting([&output.path], &self.read)
            .map_err(|error| error.to_string())?;
        Ok(output)
    }
}

impl Host for ProgramHost {
    fn texture_folders(&self, look: Option<&Path>) -> Result<Vec<PathBuf>, String> {
        library::texture_dirs(&self.texture_dirs, look).map_err(|failure| failure.to_string())
    }

    fn watch(
        &mut self,
        files: &[PathBuf],
        look: Option<&Path>,
        textures: &[PathBuf],
    ) -> Result<(), String> {
        files.clone_into(&mut self.read);
        match &mut self.watched {
            Some(watched) if watched.textures == textures => {
                watched.watcher.set_files(files, look);
            }
            watched => {
                let waker = self.waker.clone();
                let wake = move || {
                    if let Some(waker) = &waker {
                        waker.wake();
                    }
                };
                let watcher = Watcher::telling(files, look, textures, self.begun, wake);
                *watched = Some(Watched {
                    watcher: watcher.map_err(|failure| failure.to_string())?,
                    textures: textures.to_owned(),
                });
            }
        }
        Ok(())
    }

    fn changes(&mut self) -> Changes {
        let watched = self.watched.as_mut();
        let changes = watched.and_then(|watched| watched.watcher.wait(Duration::ZERO));
        changes.map_or_else(Changes::default, |changes| Changes {
            textures: changes.textures,
            look: changes.look,
            assets: changes.assets,
        })
    }

    fn wake_by(&mut self, waker: Waker) {
        let woken = waker.clone();
        interrupt::wake_by(move || woken.wake());
        self.waker = Some(waker);
    }

    fn is_ending(&self) -> bool {
        // Whoever asks keeps what is not saved; before that there is nothing, and a signal ends the program at once.
        interrupt::has_results();
        let is_ending = interrupt::requested();
        if is_ending {
            interrupt::writes_results();
        }
        is_ending
    }

    fn ends(&self, kept: Option<&str>) {
        if let Some(kept) = kept {
            console::warning(kept);
        }
        interrupt::leave_within(CLOSING);
    }

    fn patience(&self) -> Duration {
        let watched = self.watched.as_ref();
        watched.map_or(LOOKED_AT, |watched| {
            watched.watcher.patience().min(LOOKED_AT)
        })
    }

    fn report(&self, text: &str) {
        console::error(text.trim_end());
    }

    fn denoiser(&self) -> OpenDenoiser {
        Box::new(crate::denoise::open)
    }

    fn recent(&self) -> Vec<Files> {
        recent::file().map_or_else(Vec::new, |file| recent::read(&file))
    }

    fn keep_recent(&self, list: &[Files]) -> Result<(), String> {
        let Some(file) = recent::file() else {
            return Ok(());
        };
        recent::write(&file, list).map_err(|error| error.to_string())
    }

    fn check_picture(&self, path: &Path) -> Result<(), String> {
        let output = self.output(path)?;
        output::check(&output.path).map_err(|error| error.to_string())
    }

    fn write_picture(&self, path: &Path, picture: &Finished<'_>) -> Result<(), String> {
        let output = self.output(path)?;
        let Finished { origin, view, .. } = *picture;
        let content = Content {
            film: picture.film,
            layers: picture.layers,
            denoised: picture.denoised.map(|(radiance, _)| radiance),
            transparent: false,
            form: &Form::USUAL,
        };
        let written = match picture.denoised {
            Some((_, by)) => output::write_denoised(&output, content, origin, view, by),
            None => output::write(&output, content, Some(origin), view),
        };
        written.map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::without_places;

    #[test]
    fn messages_name_no_file_of_the_machine_that_built_the_program() {
        let text = "cannot open a window: winit EventLoopError: os error at /home/x-0.30/src/linux/mod.rs:765: no display";
        assert_eq!(
            without_places(text),
            "cannot open a window: winit EventLoopError: no display"
        );
        assert_eq!(without_places("os error at once"), "os error at once");
    }
}
