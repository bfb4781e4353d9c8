//! Runs the texture programs: the one kernel that holds generated code. One thread per hit with a program.

use texgen::GeneratedKernel;

use device::{Device, DeviceError, Kernel, Trust};

use crate::{gpu_scene::SceneFeatures, wave::Queue};

use super::{
    pass::{Pass, Work},
    wgsl::ComposedWgsl,
};

/// The pass; its text is generated: see [`text`].
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
};

/// There is the users' code in it.
pub const TRUST: Trust = Trust::Nothing;

/// The kernel's text with the users' functions in it.
pub fn text(generated: &GeneratedKernel) -> ComposedWgsl {
    let mut text = ComposedWgsl::of(PASS.file);
    text.append_generated(generated);
    text
}

/// Compiles the kernel with the users' functions in it, for what the scene uses.
///
/// # Errors
/// In the user's own file and line, if the driver refuses it.
pub fn kernel(
    device: &Device,
    generated: &GeneratedKernel,
    features: &SceneFeatures,
) -> Result<Kernel, DeviceError> {
    text(generated).compile(device, PASS.name, TRUST, &features.constants())
}
