//! Changes of a scene that keep its geometry: material constants, camera, environment and graph are brought to the GPU
//! together, by writes to buffers.

use crate::{
    gpu_scene::Update,
    procedural::Procedural,
    scene::{Camera, Scene},
};

use super::{RenderError, Renderer};

/// What else than the texture graph has changed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Touched {
    /// Constants of materials, or what programs decide about them.
    pub(crate) materials: bool,
    /// Intensity or rotation of the environment.
    pub(crate) environment: bool,
    /// The camera.
    pub(crate) camera: bool,
}

impl Renderer {
    /// The texture graph, to be changed; [`Self::update`] writes what has changed.
    pub(crate) fn procedural_mut(&mut self) -> &mut Procedural {
        &mut self.procedural
    }

    /// Brings the GPU up to date with the graph and with what was touched of the scene, and starts the picture anew.
    /// False where the scene has to be uploaded again; nothing has been written then.
    ///
    /// # Errors
    /// The device, or a kernel that a larger program needs.
    pub(crate) fn update(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        touched: Touched,
    ) -> Result<bool, RenderError> {
        let former = (self.scene.environment.scale, self.scene.environment.turn);
        if touched.environment && !self.scene.environment.update(&scene.environment) {
            return Ok(false);
        }
        if touched.materials {
            let procedural = &self.procedural;
            let update = self.scene.update_materials(
                &self.device,
                scene,
                |m| procedural.traits(m),
                &mut self.resources,
            )?;
            match update {
                Update::Rebuild => {
                    (self.scene.environment.scale, self.scene.environment.turn) = former;
                    return Ok(false);
                }
                Update::Written { is_moved: true } => {
                    self.bind();
                }
                Update::Written { is_moved: false } => {}
            }
        }
        if touched.camera {
            self.settings.camera = camera.clone();
        }
        self.frame = self.fresh_frame();
        self.write_changes()?;
        if touched != Touched::default() {
            self.restart();
        }
        Ok(true)
    }

    /// Renders another view from now on, from the first sample.
    pub fn set_camera(&mut self, camera: &Camera) {
        self.settings.camera = camera.clone();
        self.frame = self.fresh_frame();
        self.restart();
    }

    /// The settings, with the camera of now.
    pub fn settings(&self) -> &super::RenderSettings {
        &self.settings
    }

    /// The device.
    pub fn device(&self) -> &device::Device {
        &self.device
    }
}
