//! A picture through each camera of a scene, in files that are named after them.

use std::path::{Path, PathBuf};

use engine::scene::Camera;

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
    pub(super) fn through(&self, number: usize, name: &str) -> Self {
        let mut job = self.renamed(|path| named(path, name));
        job.camera = Some(number.to_string());
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
