//! What a pass is: one kernel of the renderer, declared once. Bindings, labels, timings and dispatches follow from it.

use device::{Device, DeviceError, Kernel, Trust};

use crate::{gpu_scene::SceneFeatures, wave::Queue};

use super::wgsl::ComposedWgsl;

/// How many threads of a pass run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// One for each path of the wave.
    Paths,
    /// One for each entry of a queue.
    Queue(Queue),
    /// One alone.
    Single,
}

/// A pass, as it is declared by the file beside its WGSL.
#[derive(Debug)]
pub struct Pass {
    /// Its entry point, which is also its name in statistics.
    pub name: &'static str,
    /// The file below `passes/` that its text begins with.
    pub file: &'static str,
    /// Its threads.
    pub work: Work,
    /// Resources that it reads.
    pub reads: &'static [&'static str],
    /// Resources that it writes, and may read as well.
    pub writes: &'static [&'static str],
    /// Whether scenes with these features need it.
    pub exists: fn(&SceneFeatures) -> bool,
}

impl Pass {
    /// What most passes have in common.
    pub const COMMON: Self = Self {
        name: "",
        file: "",
        work: Work::Single,
        reads: &[],
        writes: &[],
        exists: |_| true,
    };

    /// Its text.
    pub fn source(&self) -> ComposedWgsl {
        ComposedWgsl::of(self.file)
    }

    /// Compiles it for what a scene uses.
    ///
    /// # Errors
    /// If the driver refuses it.
    pub fn kernel(&self, device: &Device, features: &SceneFeatures) -> Result<Kernel, DeviceError> {
        let own = processor_constants(device);
        let constants = [&features.constants()[..], &own].concat();
        let source = self.source();
        source.compile(device, self.name, Trust::All, &constants)
    }
}

/// Override constants by what suits a processor or a graphics card. Whether a thread traces all rays of ambient occlusion of a hit, for
/// the kernel that does it and the one that sizes its dispatch: a graphics card needs many threads, one for each ray, a processor has
/// enough of them in the hits alone, and looks up each hit once. And where photons are looked up.
fn processor_constants(device: &Device) -> [(&'static str, f64); 2] {
    let value = f64::from(u8::from(device.traits().runs_threads_in_turn));
    [("ao_thread_per_hit", value), ("photons_by_grid", value)]
}
