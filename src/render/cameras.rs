//! The camera that is asked for; a picture through each camera of a scene, in files that are named after them.

use std::path::{Path, PathBuf};

use engine::scene::{Camera, Scene};

use crate::failure::Failure;
use crate::job::RenderJob;

/// Words for files: the cameras' names as file systems take them, no two alike.
pub(super) fn file_names(cameras: &[Camera]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (number, camera) in cameras.iter().enumerate() {
        let is_plain = |c: char| c.is_alphanumeric() || "._- ".contains(c);
        let plain = camera
            .name
            .chars()
            .map(|c| if is_plain(c) { c } else { '_' });
        let plain: String = plain.take(60).collect();
        let plain = plain.trim_matches([' ', '.']).to_owned();
        let is_taken = |name: &String| names.iter().any(|n| n.eq_ignore_ascii_case(name));
        let name = match plain.is_empty() || is_taken(&plain) {
            true => format!(
                "{plain}{}camera-{number}",
                if plain.is_empty() { "" } else { "-" }
            ),
            false => plain,
        };
        names.push(name);
    }
    names
}

impl RenderJob {
    /// The same through the camera of this number: `room.exr` becomes `room-Door.exr`.
    pub(super) fn through(&self, camera: &Camera, name: &str) -> Self {
        let mut job = self.renamed(|path| named(path, name));
        // By its name, which no other one has: a number may be the name of another.
        job.camera = Some(camera.name.clone());
        job
    }

    /// The same into files of other names.
    pub(super) fn renamed(&self, name: impl Fn(&Path) -> PathBuf) -> Self {
        let mut job = self.clone();
        for output in &mut job.outputs.pictures {
            output.path = name(&output.path);
        }
        for path in &mut job.outputs.films {
            *path = name(path);
        }
        if let Some(checkpoints) = &mut job.checkpoints {
            checkpoints.path = name(&checkpoints.path);
        }
        job.stats_json = job.stats_json.as_deref().map(name);
        job
    }
}

fn named(path: &Path, name: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut file = format!("{stem}-{name}");
    if let Some(extension) = path.extension() {
        file += &format!(".{}", extension.to_string_lossy());
    }
    path.with_file_name(file)
}

/// The camera of that name, or the one of that number where no name fits.
pub(super) fn find_camera(scene: &Scene, wanted: &str) -> Result<Camera, Failure> {
    let by_name = scene.cameras.iter().find(|camera| camera.name == wanted);
    let by_number = || scene.cameras.get(wanted.parse::<usize>().ok()?);
    by_name.or_else(by_number).cloned().ok_or_else(|| {
        let names: Vec<_> = scene
            .cameras
            .iter()
            .map(|camera| format!("'{}'", camera.name))
            .collect();
        Failure::Failed(if names.is_empty() {
            format!("--camera {wanted}: the scene has no cameras; leave the flag out for a view of everything")
        } else {
            format!(
                "--camera {wanted}: the scene has no camera of this name; it has {}",
                names.join(", ")
            )
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::scene::Projection;

    #[test]
    fn files_are_named_after_cameras() {
        assert_eq!(
            named(Path::new("a/room.exr"), "Door"),
            Path::new("a/room-Door.exr")
        );
        assert_eq!(
            named(Path::new("a/my.room.exr"), "Door"),
            Path::new("a/my.room-Door.exr")
        );
    }

    fn scene(names: &[&str]) -> Scene {
        let cameras = names
            .iter()
            .map(|&name| Camera {
                name: name.to_owned(),
                transform: glam::Affine3A::IDENTITY,
                projection: Projection::Perspective { y_fov: 1.0 },
                aperture_radius: 0.0,
                aperture_blades: 0,
                aperture_rotation: 0.0,
                focus_distance: 1.0,
            })
            .collect();
        Scene {
            cameras,
            ..Scene::default()
        }
    }

    fn found(names: &[&str], wanted: &str) -> Result<String, String> {
        match find_camera(&scene(names), wanted) {
            Ok(camera) => Ok(camera.name),
            Err(Failure::Failed(text)) => Err(text),
            Err(other) => panic!("a camera is not a usage error: {other:?}"),
        }
    }

    #[test]
    fn a_camera_is_found_by_name_then_by_number() {
        assert_eq!(found(&["1", "Door"], "1").as_deref(), Ok("1"));
        assert_eq!(found(&["Door", "Bed"], "1").as_deref(), Ok("Bed"));
    }

    #[test]
    fn an_unknown_camera_is_answered_with_the_names() {
        let error = found(&["Door", "Bed"], "Roof").unwrap_err();
        assert!(error.contains("'Door', 'Bed'"), "{error}");
        let error = found(&[], "Roof").unwrap_err();
        assert!(error.contains("no cameras"), "{error}");
    }
}
