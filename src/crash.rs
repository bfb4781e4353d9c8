//! Textures that end the program: a driver may crash on a kernel that is valid. A marker file stands while a kernel is
//! built and run for the first time; whoever finds that of a dead process builds the kernel's textures one by one, each
//! in a process of its own, and names those that don't survive.

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use device::gpu::fnv1a;
use device::{Device, DeviceChoice, DeviceDescription};
use engine::aside::Leftover;
use engine::procedural::{Procedural, TextureSources};
use engine::renderer::{RenderSettings, Renderer};
use texgen::SourceFile;

use crate::failure::Failure;
use crate::{interrupt, probe};

/// What is said when a marker is found.
pub(crate) const SUSPICION: &str = "the last run with these textures ended without a word while their kernel was built; \
     each of them is now built alone, to find one that the driver doesn't survive";

/// A texture that takes longer than this alone would not be waited for either.
const PATIENCE: Duration = Duration::from_secs(60);

/// Stands in the cache folder while a kernel is built; gone once it is dropped, but not when the process dies.
#[derive(Debug)]
pub(crate) struct Marker {
    path: PathBuf,
    /// A program that is ended by a signal takes it away: then nothing has crashed.
    _leftover: Leftover,
    /// Locked: a marker that isn't belongs to a process that is gone.
    _file: File,
}

impl Marker {
    /// Sets the marker of a kernel on a device, and tells whether a process that is gone has left it. No marker where
    /// there is no folder, the folder can't be written, or another process builds the same kernel right now.
    pub(crate) fn set(
        folder: Option<&Path>,
        kernel: &str,
        device: &DeviceDescription,
    ) -> (Option<Self>, bool) {
        let Some(folder) = folder else {
            return (None, false);
        };
        let key = format!("{} {} {kernel}", device.name, device.driver);
        let path = folder.join(format!("building_{:016x}", fnv1a(key.as_bytes())));
        Self::set_at(path).unwrap_or((None, false))
    }

    fn set_at(path: PathBuf) -> Option<(Option<Self>, bool)> {
        std::fs::create_dir_all(path.parent()?).ok()?;
        let mut file = File::options()
            .create(true)
            .read(true)
            .append(true)
            .open(&path)
            .ok()?;
        file.try_lock().ok()?;
        let mut found = String::new();
        file.read_to_string(&mut found).ok()?;
        if found.is_empty() {
            file.write_all(b"a texture kernel is being built\n").ok()?;
        }
        let marker = Self {
            _leftover: Leftover::new(path.clone()),
            path,
            _file: file,
        };
        Some((Some(marker), !found.is_empty()))
    }
}

impl Drop for Marker {
    fn drop(&mut self) {
        // Left behind, it costs the next start a look at each texture.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Builds each texture of a kernel in a process of its own, and tells before each which one it is.
///
/// # Errors
/// Names the textures that don't survive it. If all do, something else ended the program.
pub(crate) fn find(
    procedural: &Procedural,
    device: usize,
    tell: impl Fn(&str),
) -> Result<(), Failure> {
    let textures = procedural.graph().library().textures();
    let paths = textures.iter().map(|texture| texture.file().path());
    let problems = problems(paths, |path| {
        tell(path);
        let program = std::env::current_exe().unwrap_or_else(|_| "patina".into());
        let mut command = Command::new(program);
        command
            .arg("probe-texture")
            .arg(path)
            .arg("--device")
            .arg(device.to_string());
        command
    });
    match problems.is_empty() {
        true => Ok(()),
        false => Err(Failure::Failed(problems.join("\n"))),
    }
}

/// Starts a command for each file and tells what went wrong.
fn problems<'p>(
    paths: impl Iterator<Item = &'p str>,
    command: impl Fn(&str) -> Command,
) -> Vec<String> {
    let verdict = |path: &'p str| {
        let said = "rewrite it, or take it out of the look";
        let child = command(path)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        let child = match child {
            Ok(child) => child,
            Err(error) => return Some(format!("{path}: can't be built alone: {error}")),
        };
        match probe::wait(child, PATIENCE) {
            Some(status) if status.success() => None,
            // A device that refuses it says so itself when the kernel is built.
            Some(status) if status.code() == Some(1) => None,
            // Somebody had no patience: that says nothing about the texture.
            Some(status) if interrupt::is_cause_of(status) => None,
            Some(status) => Some(format!(
                "{path}: this texture ends the graphics driver ({status}); {said}"
            )),
            None => Some(format!(
                "{path}: the graphics driver doesn't finish this texture within {} s; {said}",
                PATIENCE.as_secs()
            )),
        }
    };
    paths.filter_map(verdict).collect()
}

/// `patina probe-texture`: builds one texture alone and runs it.
///
/// # Errors
/// The file can't be read, the texture is wrong, or the device refuses it.
pub(crate) fn probe(path: &Path, device: &DeviceChoice) -> Result<(), Failure> {
    let file = TextureSources::open(path).map_err(Failure::because)?;
    let file = SourceFile::new("probe", file.path(), file.text()).with_libraries(file.libraries());
    let (scene, procedural) = Procedural::probe(&file).map_err(Failure::because)?;
    let device = Device::open(device).map_err(Failure::because)?;
    let settings = RenderSettings {
        max_depth: 1,
        ..RenderSettings::new(8, 8, &engine::scene::default_camera(&scene))
    };
    Renderer::new(&device, &scene, &procedural, &settings)
        .and_then(|mut renderer| renderer.render(1))
        .map_err(Failure::because)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_marker_tells_of_a_process_that_is_gone() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("below").join("building_1");
        let set = || Marker::set_at(path.clone());
        let (marker, has_crashed) = set().expect("the folder can be written");
        assert!(marker.is_some() && !has_crashed);
        assert!(set().is_none(), "another process builds it");
        drop(marker);
        assert!(!path.exists(), "removed when all went well");
        std::fs::write(&path, "left behind").expect("written");
        let (marker, has_crashed) = set().expect("nobody holds it");
        assert!(marker.is_some() && has_crashed);
        drop(marker);
        let (_, has_crashed) = set().expect("the folder can be written");
        assert!(!has_crashed, "said once");
    }

    #[test]
    #[cfg(unix)]
    fn the_textures_that_end_their_process_are_named() {
        let shell = |path: &str| {
            let mut command = Command::new("sh");
            let line = match path {
                "bad.wgsl" => "kill -SEGV $$",
                "aborts.wgsl" => "exit 134",
                "interrupted.wgsl" => "kill -INT $$",
                "ended.wgsl" => "kill -TERM $$",
                "by-itself.wgsl" => "exit 129",
                "refused.wgsl" => "exit 1",
                _ => "exit 0",
            };
            command.args(["-c", line]);
            command
        };
        let paths = [
            "a.wgsl",
            "bad.wgsl",
            "refused.wgsl",
            "interrupted.wgsl",
            "ended.wgsl",
            "by-itself.wgsl",
            "aborts.wgsl",
        ];
        let found = problems(paths.into_iter(), shell);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].starts_with("bad.wgsl: this texture ends the graphics driver"));
        assert!(found[1].starts_with("aborts.wgsl"));
        let missing = problems(["a.wgsl"].into_iter(), |_| {
            Command::new("no-such-program-here")
        });
        assert!(missing[0].contains("can't be built alone"), "{missing:?}");
    }
}
