//! All passes in one kernel on hardware ray queries, for comparison: a thread takes a path from the camera to the film. One
//! thread per path.

use texgen::GeneratedKernel;

use device::{Device, DeviceError, Kernel, Trust};

use crate::gpu_scene::SceneFeatures;
use crate::passes::wgsl::Source;

/// Name of the entry point.
pub const ENTRY: &str = "trace_paths";

/// The kernel's text: with texgen's inlined form and room for `result_words` of its results, or without textures.
pub fn source(generated: Option<&GeneratedKernel>, result_words: u32) -> Source {
    let mut source = Source::of(match generated {
        Some(_) => "rayquery/textured.wgsl",
        None => "rayquery/plain.wgsl",
    });
    source.append_constant("RESULT_WORDS", result_words.max(1));
    if let Some(generated) = generated {
        source.append_generated(generated);
    }
    source
}

/// Values of its `override` constants. `is_single_sided`: rays pass the back of every triangle of the scene.
pub fn constants(features: &SceneFeatures, is_single_sided: bool) -> Vec<(&'static str, f64)> {
    let mut constants = features.constants().to_vec();
    constants.push(("is_single_sided", f64::from(u8::from(is_single_sided))));
    constants
}

/// Compiles the kernel of this [`source`] with these [`constants`]. The device must have been opened with ray queries.
///
/// # Errors
/// In the user's own file and line, if the driver refuses it.
pub fn kernel(
    device: &Device,
    source: &Source,
    constants: &[(&'static str, f64)],
) -> Result<Kernel, DeviceError> {
    source.compile(device, ENTRY, Trust::Loops, constants)
}
