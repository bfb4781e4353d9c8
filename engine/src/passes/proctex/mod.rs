//! Runs the texture programs: the one kernel that holds generated code. One thread per hit with a program.

use texgen::GeneratedKernel;

use crate::gpu::{
    Gpu, GpuError,
    kernel::{Kernel, Trust},
    wgsl::Source,
};
use crate::gpu_scene::SceneFeatures;

/// The two forms of the generated kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TextureForm {
    /// It interprets programs with a small stack; ambient occlusion was traced before it runs. Edits are data.
    #[default]
    Stack,
    /// Constants and links are pasted into it, and it traces ambient occlusion itself. Any edit builds it again: this is
    /// for comparison with renderers that work so. Needs ten storage buffers per stage.
    Inlined,
}

/// Name of the entry point.
pub const ENTRY: &str = "proctex";

/// The kernel's text with the users' functions in it.
pub fn source(form: TextureForm, generated: &GeneratedKernel) -> Source {
    let mut source = Source::of(match form {
        TextureForm::Stack => "proctex/proctex.wgsl",
        TextureForm::Inlined => "proctex/inlined.wgsl",
    });
    source.append_generated(generated);
    source
}

/// Compiles the kernel with the users' functions in it, for what the scene uses.
///
/// # Errors
/// In the user's own file and line, if the driver refuses it.
pub fn kernel(
    gpu: &Gpu,
    form: TextureForm,
    generated: &GeneratedKernel,
    features: &SceneFeatures,
) -> Result<Kernel, GpuError> {
    let source = source(form, generated);
    Kernel::new(gpu, &source, ENTRY, Trust::User, &features.constants())
}
