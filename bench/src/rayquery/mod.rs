//! A path tracer in one kernel on hardware ray queries, with the textures pasted in and ambient occlusion traced in a loop:
//! what the renderer of this project is compared with. The picture is the same.
//!
//! Any edit builds the kernel again. Everything else that the comparison needs to be fair is shared: the scene's buffers,
//! the WGSL of every step, the waves and their length. `kernel.wgsl` takes a path from the camera to the film; where a wave's
//! passes keep rays and paths in buffers, `path_memory.wgsl` keeps them in private variables.

mod structure;

use std::borrow::Cow;
use std::sync::Arc;

use device::{Device, DeviceError, KernelText, Resources, Trust, Usage};
use engine::{
    gpu_scene::SceneFeatures,
    passes::{
        pass::{Pass, Work},
        wgsl::ComposedWgsl,
    },
    procedural::{CompileError, Procedural},
    schedule::{Run, Schedule, ScheduleError, Upload},
    wave,
};
use texgen::GeneratedKernel;

use crate::wgsl;

/// All passes in one: a thread takes a path from the camera to the film. Its text is composed by [`text`].
pub static PASS: Pass = Pass {
    name: "trace_paths",
    file: "rayquery/textured.wgsl",
    work: Work::Paths,
    reads: &[
        "albedo_table",
        "ao_tables",
        "args",
        "environment_image",
        "environment_table",
        "facing_sky",
        "filter_table",
        "first_triangles",
        "frame",
        "image_layers",
        "image_layers_srgb",
        "image_table",
        "instances",
        "known_sky",
        "lights",
        "materials",
        "programs",
        "scene_structure",
        "triangles",
        "vertices",
    ],
    writes: &["film0", "film1", "film2", "film3", "film4", "queues"],
    ..Pass::COMMON
};

static PASSES: [&Pass; 1] = [&PASS];

/// A wave is one dispatch.
#[derive(Debug, Clone, Copy, Default)]
pub struct RayQueries {
    /// Rays pass the back of every triangle of the scene, so that the hardware may leave out all backs.
    is_single_sided: bool,
}

/// The kernel's text: with texgen's inlined form and room for `result_words` of its results, or without textures.
pub fn text(generated: Option<&GeneratedKernel>, result_words: u32) -> ComposedWgsl {
    let mut text = wgsl::compose(match generated {
        Some(_) => PASS.file,
        None => "rayquery/plain.wgsl",
    });
    text.append_constant("RESULT_WORDS", result_words.max(1));
    if let Some(generated) = generated {
        text.append_generated(generated);
    }
    text
}

impl Schedule for RayQueries {
    fn passes(&self) -> &'static [&'static Pass] {
        &PASSES
    }

    fn texture_pass(&self) -> &'static Pass {
        &PASS
    }

    /// It is there without textures too: it is all there is.
    fn texture_kernel(
        &self,
        features: &SceneFeatures,
        procedural: &Procedural,
    ) -> Result<Option<KernelText>, CompileError> {
        let generated = match procedural.is_empty() {
            true => None,
            false => Some(procedural.inlined()?.kernel),
        };
        let mut constants = features.constants().to_vec();
        let is_single_sided = f64::from(u8::from(self.is_single_sided));
        constants.push(("is_single_sided", is_single_sided));
        Ok(Some(KernelText {
            text: Arc::new(text(generated.as_ref(), procedural.result_words())),
            entry: PASS.name,
            trust: Trust::Loops,
            constants,
        }))
    }

    fn program_words<'a>(
        &self,
        procedural: &'a Procedural,
    ) -> Result<Cow<'a, [u32]>, CompileError> {
        Ok(Cow::Owned(procedural.inlined()?.heads))
    }

    fn edits_are_code(&self) -> bool {
        true
    }

    /// The scene's acceleration structures; of queues only the totals, of paths nothing.
    fn allocate(&mut self, upload: Upload<'_>, to: &mut Resources) -> Result<(), ScheduleError> {
        let device = upload.device;
        if !device.has_ray_queries() {
            let reason = "this device has no ray queries, or was opened without them";
            return Err(ScheduleError::Unsupported(reason));
        }
        self.is_single_sided = structure::build(&upload, to)?;
        let totals = device.buffer("totals", Usage::Storage, wave::QUEUE_HEADER * 4)?;
        to.set_buffer("queues", totals);
        Ok(wave::allocate_ao_tables(device, to)?)
    }

    /// Results are private variables of the kernel.
    fn grow_results(
        &self,
        _: &Device,
        _: u32,
        _: u32,
        _: &mut Resources,
    ) -> Result<bool, DeviceError> {
        Ok(false)
    }

    fn goes_in_rounds(&self) -> bool {
        false
    }

    fn end(&self, wave: &mut dyn Run) {
        wave.run(&PASS);
    }
}
