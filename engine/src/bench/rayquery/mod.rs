//! A path tracer in one kernel on hardware ray queries, with the textures pasted in and ambient occlusion traced in a loop:
//! what the renderer of this project is compared with. The picture is the same; `passes/rayquery` has the kernel.
//!
//! Any edit builds the kernel again. Everything else that the comparison needs to be fair is shared: the scene's buffers,
//! the WGSL of every step, the waves and their length.

mod structure;

use std::sync::Arc;
use std::time::Instant;

use texgen::{SourceFile, Value};

use crate::passes::wgsl::{Source, private_bytes};
use device::{BoundKernel, Device, Extent, Kernel, KernelText, Recording, Resources, Trust, Usage};

use crate::{
    film::{self, Film, Layers},
    frame::Frame,
    gpu_scene::GpuScene,
    passes::{proctex::TextureForm, rayquery},
    procedural::Procedural,
    renderer::{
        LONGEST_WAVE, ReloadError, RenderEditError, RenderError, RenderSettings, allocate_picture,
        allocate_textures, clear_picture, default_capacity, first_wave, next_wave, read_picture,
    },
    scene::Scene,
    wave,
};

/// Renders one scene progressively, a wave by a single dispatch.
#[derive(Debug)]
pub struct RayQueryRenderer {
    gpu: Device,
    settings: RenderSettings,
    procedural: Procedural,
    scene: GpuScene,
    is_single_sided: bool,
    resources: Resources,
    kernel: Kernel,
    bound: BoundKernel,
    frame: Frame,
    capacity: u32,
    wave_size: u32,
    position: u64,
}

impl RayQueryRenderer {
    /// Uploads the scene, builds its acceleration structures and compiles the kernel.
    ///
    /// # Errors
    /// A device without ray queries (see [`device::DeviceOptions::ray_queries`]), a scene that is empty or too large, a texture that
    /// does not build.
    pub fn new(
        gpu: &Device,
        scene: &Scene,
        procedural: &Procedural,
        settings: &RenderSettings,
    ) -> Result<Self, RenderError> {
        if !gpu.has_ray_queries() {
            return Err(RenderError::NoRayQueries);
        }
        // It has the passes' picture to be compared with, and nothing else of them.
        let settings = &RenderSettings {
            layers: Layers::default(),
            ..settings.clone()
        };
        let mut resources = Resources::default();
        allocate_picture(gpu, settings, &mut resources)?;
        let traits = |m| procedural.traits(m);
        let mut gpu_scene = GpuScene::new(gpu, scene, &procedural.reads(), traits, &mut resources)?;
        gpu_scene.features.energy_compensation = settings.energy_compensation;
        let is_single_sided = structure::build(gpu, scene, traits, &gpu_scene, &mut resources)?;
        // Of the queues only the totals.
        let header = wave::QUEUE_HEADER * 4;
        let queues = gpu.buffer("totals", Usage::Storage, header)?;
        resources.set_buffer("queues", queues);
        wave::allocate_ao_tables(gpu, &mut resources)?;
        allocate_textures(gpu, procedural, TextureForm::Inlined, &mut resources)?;
        let source = source(procedural)?;
        let constants = rayquery::constants(&gpu_scene.features, is_single_sided);
        let kernel = rayquery::kernel(gpu, &source, &constants)?;
        let capacity = default_capacity(gpu);
        gpu.check()?;
        Ok(Self {
            gpu: gpu.clone(),
            settings: settings.clone(),
            procedural: procedural.clone(),
            is_single_sided,
            bound: kernel.bind(gpu, &resources),
            kernel,
            resources,
            frame: Frame::new(settings, capacity, &gpu_scene),
            scene: gpu_scene,
            capacity,
            wave_size: first_wave(gpu, capacity),
            position: 0,
        })
    }

    /// Renders up to `target_spp` samples per pixel, at most [`film::MAX_SAMPLES`].
    ///
    /// # Errors
    /// What the driver reports.
    pub fn render(&mut self, target_spp: u32) -> Result<(), RenderError> {
        let first = self.settings.first_sample;
        let target_spp = target_spp.min(film::MAX_SAMPLES).min(u32::MAX - first);
        let padded = u64::from(self.frame.padded_pixels);
        let total = padded * u64::from(target_spp);
        while self.position < total {
            let start = Instant::now();
            let wave = u64::from(self.wave_size).min(total - self.position);
            let frame = &mut self.frame;
            frame.set_wave(self.position, wave as u32, first, target_spp);
            let frame = self.resources.buffer("frame");
            self.gpu.write(frame, 0, bytemuck::bytes_of(&self.frame));
            let mut recording = Recording::new("wave");
            let threads = Extent::Threads(wave.min(padded) as u32);
            recording.dispatch(&self.bound, threads);
            self.gpu.play(&recording)?;
            self.position += wave;
            let took = start.elapsed();
            self.wave_size = next_wave(self.wave_size, self.capacity, took, LONGEST_WAVE);
        }
        Ok(())
    }

    /// Forgets all samples.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn restart(&mut self) -> Result<(), RenderError> {
        self.position = 0;
        Ok(clear_picture(&self.gpu, &self.settings, &self.resources)?)
    }

    /// What has been gathered so far.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn film(&self) -> Result<Film, RenderError> {
        Ok(read_picture(&self.gpu, &self.settings, &self.resources)?)
    }

    /// Sets a parameter of a node to a constant, and builds the kernel with it.
    ///
    /// # Errors
    /// Unknown names, a value of another type, or the device.
    pub fn set_argument(
        &mut self,
        node: &str,
        parameter: &str,
        value: Value,
    ) -> Result<(), RenderEditError> {
        self.procedural.set_value(node, parameter, value)?;
        Ok(self.rebuild()?)
    }

    /// Puts these textures in the place of those of their names, and builds the kernel with them.
    ///
    /// # Errors
    /// Wrong textures, with file and line; a kernel that the driver refuses.
    pub fn reload(&mut self, files: Vec<SourceFile>) -> Result<(), ReloadError> {
        let library = Arc::new(self.procedural.library_with(files)?);
        self.procedural = self.procedural.with_library(library)?;
        Ok(self.rebuild()?)
    }

    /// The texture graph as it is now.
    pub fn procedural(&self) -> &Procedural {
        &self.procedural
    }

    /// Bytes of private memory that a thread of the kernel asks for: see [`texgen::kernel_private_bytes`].
    pub fn private_bytes(&self) -> u32 {
        let text = self.kernel_text().ok();
        text.and_then(|text| private_bytes(&text)).unwrap_or(0)
    }

    /// The kernel's text, for tools.
    ///
    /// # Errors
    /// Programs that have no inlined form.
    pub fn kernel_text(&self) -> Result<KernelText, RenderError> {
        Ok(KernelText {
            text: Arc::new(source(&self.procedural)?),
            entry: rayquery::ENTRY,
            trust: Trust::Loops,
            constants: rayquery::constants(&self.scene.features, self.is_single_sided),
        })
    }

    fn rebuild(&mut self) -> Result<(), RenderError> {
        let source = source(&self.procedural)?;
        let constants = rayquery::constants(&self.scene.features, self.is_single_sided);
        self.kernel = rayquery::kernel(&self.gpu, &source, &constants)?;
        let form = TextureForm::Inlined;
        allocate_textures(&self.gpu, &self.procedural, form, &mut self.resources)?;
        self.bound = self.kernel.bind(&self.gpu, &self.resources);
        self.restart()
    }
}

fn source(procedural: &Procedural) -> Result<Source, RenderError> {
    let generated = match procedural.is_empty() {
        true => None,
        false => Some(procedural.inlined()?.kernel),
    };
    Ok(rayquery::source(
        generated.as_ref(),
        procedural.result_words(),
    ))
}
