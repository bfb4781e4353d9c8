//! A scene and its look, rendered: 8 x 8 pixels, one sample each. Does nothing where no device can render.

use std::str;
use std::sync::OnceLock;

use device::Device;
use engine::load;
use engine::renderer::{RenderError, RenderSettings, Renderer};
use engine::scene::look::Look;

use crate::mutate::split;
use crate::{check_message, file, scratch};

const SIDE: u32 = 8;
/// More takes longer and shows nothing new.
const MANY_TRIANGLES: usize = 50_000;
const MANY_LIGHTS: usize = 10_000;

/// The device, opened once.
fn device() -> Option<&'static Device> {
    static GPU: OnceLock<Option<Device>> = OnceLock::new();
    let open = || match Device::best() {
        Ok(device) => Some(device),
        Err(error) => {
            let is_required = std::env::var_os("PATINA_REQUIRE_DEVICE").is_some();
            assert!(!is_required, "PATINA_REQUIRE_DEVICE is set, but: {error}");
            eprintln!("nothing is rendered: {error}");
            None
        }
    };
    GPU.get_or_init(open).as_ref()
}

pub(crate) fn run(data: &[u8]) -> bool {
    let Some(device) = device() else { return false };
    let (scene, look) = split(data);
    let path = file("rendered.gltf", scene);
    let look = match str::from_utf8(look) {
        Ok("") | Err(_) => None,
        Ok(text) => Look::parse(&scratch().join("rendered.look.toml"), text).ok(),
    };
    let Ok(loaded) = load::load_with(&path, look, &[]) else {
        return false;
    };
    let scene = &loaded.scene;
    let lamps = scene.lights.len() + scene.instances.len();
    if scene.instanced_triangles() as usize > MANY_TRIANGLES || lamps > MANY_LIGHTS {
        return false;
    }
    let settings = RenderSettings::new(SIDE, SIDE, &loaded.camera);
    let mut renderer = match Renderer::new(device, scene, &loaded.procedural, &settings) {
        Ok(renderer) => renderer,
        Err(RenderError::Scene(error)) => {
            check_message(&error.to_string());
            return false;
        }
        Err(error) => panic!("{error}"),
    };
    renderer.render(1).unwrap_or_else(|error| panic!("{error}"));
    let film = renderer.film().unwrap_or_else(|error| panic!("{error}"));
    device.check().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(film.sample_bounds(), (1, 1), "each pixel has its sample");
    assert!(film.mean().iter().flatten().all(|v| v.is_finite()));
    true
}
