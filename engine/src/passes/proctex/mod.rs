//! Runs the texture programs: the one kernel that holds generated code. One thread per hit with a program.

use texgen::GeneratedKernel;

use crate::gpu::{
    Gpu, GpuError,
    kernel::{Kernel, Trust},
    wgsl::Source,
};

/// Compiles the kernel with the users' functions in it.
///
/// # Errors
/// In the user's own file and line, if the driver refuses it.
pub fn kernel(gpu: &Gpu, generated: &GeneratedKernel) -> Result<Kernel, GpuError> {
    let mut source = Source::of("proctex/proctex.wgsl");
    source.append_generated(generated);
    Kernel::new(gpu, &source, "proctex", Trust::User, &[])
}
