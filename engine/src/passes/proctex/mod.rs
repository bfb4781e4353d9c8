//! Runs the texture programs: the one kernel that holds generated code. One thread per hit with a program.

use texgen::GeneratedKernel;

use device::{Device, DeviceError, Kernel, Trust};

use crate::{gpu_scene::SceneFeatures, wave::Queue};

use super::{
    pass::{Pass, Work},
    wgsl::Source,
};

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

/// The pass; its text is generated: see [`kernel`].
pub const PASS: Pass = Pass {
    name: "proctex",
    file: "proctex/proctex.wgsl",
    work: Work::Queue(Queue::Proctex),
    reads: &[
        "args",
        "frame",
        "image_layers",
        "image_layers_srgb",
        "image_table",
        "instances",
        "programs",
        "triangles",
        "vertices",
    ],
    writes: &["paths", "queues", "rays"],
    exists: |features| features.programs,
    ..Pass::COMMON
};

/// What the inlined form begins with.
const INLINED: &str = "proctex/inlined.wgsl";

/// The kernel's text with the users' functions in it.
pub fn source(form: TextureForm, generated: &GeneratedKernel) -> Source {
    let mut source = Source::of(match form {
        TextureForm::Stack => PASS.file,
        TextureForm::Inlined => INLINED,
    });
    source.append_generated(generated);
    source
}

/// Compiles the kernel with the users' functions in it, for what the scene uses.
///
/// # Errors
/// In the user's own file and line, if the driver refuses it.
pub fn kernel(
    device: &Device,
    form: TextureForm,
    generated: &GeneratedKernel,
    features: &SceneFeatures,
) -> Result<Kernel, DeviceError> {
    let source = source(form, generated);
    source.compile(device, PASS.name, Trust::Nothing, &features.constants())
}
