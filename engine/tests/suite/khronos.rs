//! Every sample model renders: something is seen, and every sample is finite.

use std::path::{Path, PathBuf};

use engine::load::load;
use engine::renderer::{RenderSettings, Renderer};
use engine::scene::Environment;
use glam::Vec3;

use crate::support::{device, shared};

fn model_file(folder: &Path) -> Option<PathBuf> {
    let files = std::fs::read_dir(folder).ok()?.flatten().map(|e| e.path());
    files
        .into_iter()
        .find(|p| p.extension().is_some_and(|e| e == "glb" || e == "gltf"))
}

#[test]
fn sample_models_render() {
    let Some(folder) = shared::find("scenes/khronos") else {
        return;
    };
    let Some(device) = device::open() else { return };
    let mut folders: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the folder was found")
        .flatten()
        .map(|entry| entry.path())
        .collect();
    folders.sort();
    let mut rendered = 0;
    for folder in folders {
        let name = folder
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let Some(file) = model_file(&folder) else {
            continue;
        };
        let mut loaded = load(&file, None, &[]).unwrap_or_else(|e| panic!("{name}: {e}"));
        // The same light for all, none of it from within, so that a black picture is a failure.
        loaded.scene.environment = Environment::Constant(Vec3::ONE);
        let settings = RenderSettings {
            max_depth: 3,
            ..RenderSettings::new(32, 24, &loaded.camera)
        };
        let mut renderer = Renderer::new(&device, &loaded.scene, &loaded.procedural, &settings)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        renderer.render(4).unwrap_or_else(|e| panic!("{name}: {e}"));
        let stats = renderer.stats().unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(stats.invalid_samples, 0, "{name}: samples are not finite");
        let mean = renderer
            .film()
            .unwrap_or_else(|e| panic!("{name}: {e}"))
            .mean();
        // The sky is exactly 1: what differs from it is the model.
        let seen = mean
            .iter()
            .filter(|p| p.iter().any(|v| (v - 1.0).abs() > 0.01))
            .count();
        assert!(seen > 4, "{name}: nothing is seen of it");
        rendered += 1;
    }
    assert!(
        rendered >= 40,
        "only {rendered} models were found and rendered"
    );
    eprintln!("{rendered} models rendered");
}
