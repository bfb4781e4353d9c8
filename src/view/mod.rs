//! `patina view`: the window of `patina_viewer`, with this program's files, formats and folders.

pub(crate) mod args;
pub(crate) mod job;

use std::path::{Path, PathBuf};
use std::time::Duration;

use engine::film::Film;
use engine::gpu::Gpu;
use patina_viewer::host::{Changes, Host};
use patina_viewer::link::Files;
use patina_viewer::shell::{self, WindowOptions};
use patina_viewer::thread::RenderOptions;

use crate::exit::Failure;
use crate::job::parse_output;
use crate::output::{self, Fact, Picture};
use crate::watch::files::Watcher;
use crate::{cache, console, library};

use job::ViewJob;

/// Pixels of a picture before the window has said how large it is.
const FIRST_SIZE: [u32; 2] = [640, 360];

/// Opens the window and returns when it has been closed.
///
/// # Errors
/// There is no device or no window system, or a file on the command line isn't there.
pub(crate) fn run(job: &ViewJob) -> Result<(), Failure> {
    // Said at once rather than in a window.
    for file in job.scene.iter().chain(&job.look) {
        std::fs::metadata(file)
            .map_err(|error| Failure::Failed(format!("cannot read {}: {error}", file.display())))?;
    }
    if let Some((output, _)) = &job.screenshot {
        output::check(&output.path).map_err(Failure::because)?;
    }
    let host = ProgramHost {
        texture_dirs: job.texture_dirs.clone(),
        watched: None,
    };
    library::texture_dirs(&job.texture_dirs, job.look.as_deref())?;
    let folder = cache::folder();
    let gpu = Gpu::with_cache(&job.device, folder.as_deref()).map_err(Failure::because)?;
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
        preview_device: job.device.clone(),
        picture_at_spp: job.screenshot.as_ref().map(|(_, spp)| *spp),
    };
    let outcome = shell::run(&gpu, options, Box::new(host)).map_err(Failure::because);
    // Nothing depends on it but the time of the next start.
    let _ = gpu.save_cache();
    match (outcome?, &job.screenshot) {
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

/// What the window wants of this program.
struct ProgramHost {
    /// Folders named on the command line.
    texture_dirs: Vec<PathBuf>,
    watched: Option<Watched>,
}

struct Watched {
    watcher: Watcher,
    textures: Vec<PathBuf>,
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
        match &mut self.watched {
            Some(watched) if watched.textures == textures => {
                watched.watcher.set_files(files, look);
            }
            watched => {
                let watcher = Watcher::new(files, look, textures);
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

    fn write_film(&self, path: &Path, film: &Film) -> Result<(), String> {
        let (spp, _) = film.sample_bounds();
        let picture = Picture {
            width: film.width,
            height: film.height,
            rgb: film.mean(),
            facts: vec![("samplesPerPixel", Fact::Count(spp.into()))],
        };
        let output = parse_output(path.to_owned()).map_err(|error| error.to_string())?;
        output::write(&output, &picture, 0.0).map_err(|error| error.to_string())
    }

    fn write_shown(&self, path: &Path, size: [u32; 2], rgba: &[u8]) -> Result<(), String> {
        let output = parse_output(path.to_owned()).map_err(|error| error.to_string())?;
        output::write_shown(&output, size, rgba).map_err(|error| error.to_string())
    }
}
