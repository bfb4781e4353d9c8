//! Changes of a scene that keep its geometry: material constants, camera, environment and graph are brought to the GPU
//! together, by writes to buffers.

use crate::{
    gpu_scene::Update,
    procedural::Procedural,
    scene::{Camera, Scene},
};

use super::pipeline::Kernels;
use super::{RenderError, RenderSettings, Renderer, light_cache};

/// What else than the texture graph has changed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Touched {
    /// Constants of materials, or what programs decide about them.
    pub(crate) materials: bool,
    /// Intensity or rotation of the environment.
    pub(crate) environment: bool,
    /// The camera.
    pub(crate) camera: bool,
    /// Punctual lights.
    pub(crate) lights: bool,
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
        if touched.environment
            && !self
                .scene
                .environment
                .update(&self.device, &scene.environment)
        {
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
        if touched.lights {
            match (self.scene).update_lights(&self.device, scene, &mut self.resources)? {
                Update::Rebuild => return Ok(false),
                Update::Written { is_moved: true } => self.bind(),
                Update::Written { is_moved: false } => {}
            }
        }
        if touched.camera {
            self.settings.camera = camera.clone();
        }
        self.renew_frame();
        self.write_changes()?;
        if touched != Touched::default() {
            self.restart();
        }
        Ok(true)
    }

    /// Goes from one scene, which is on the device, to another one with textures of its own; only what has changed is sent. Size and
    /// layers of the settings are those that it has.
    ///
    /// The picture begins anew, unless it `goes_on`: then what is rendered next is added to it, by a light that is found out
    /// anew.
    ///
    /// # Errors
    /// As [`Renderer::new`]; what is on the device then is of no use.
    pub(crate) fn show(
        &mut self,
        [before, scene]: [&Scene; 2],
        procedural: &Procedural,
        settings: &RenderSettings,
        goes_on: bool,
    ) -> Result<(), RenderError> {
        let device = self.device.clone();
        let nodes = settings.layers.nodes();
        let procedural = &procedural.showing(nodes).map_err(RenderError::Node)?;
        let former = std::mem::replace(&mut self.procedural, procedural.clone());
        let features = self.scene.features;
        let reads = [&former.reads(), &procedural.reads()];
        let program = |m| procedural.traits(m);
        (self.scene).show(
            &device,
            [before, scene],
            reads,
            program,
            &mut self.resources,
        )?;
        super::show_motion(&device, &self.scene, scene, settings, &mut self.resources)?;
        let needs_kernels = features != self.scene.features || !former.has_kernel_of(procedural);
        if needs_kernels {
            self.kernels = Kernels::new(
                &device,
                &self.scene.features,
                &settings.layers,
                procedural,
                &*self.schedule,
            )?;
            self.is_warm = false;
        }
        if let (Some(photons), true) = (&mut self.photons, features != self.scene.features) {
            photons.compile(&device, &self.scene.features)?;
        }
        self.resize_programs(&former)?;
        self.settings = settings.clone();
        self.bind();
        self.frame = self.fresh_frame();
        self.forget_guides();
        self.survey = None;
        match goes_on {
            // What is known of the light is that of the moment before.
            true => {
                self.forget_light();
                light_cache::clear(&device, self.settings.method, &self.resources)?;
            }
            false => self.restart(),
        }
        Ok(device.check()?)
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
