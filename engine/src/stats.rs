//! Where the time and the memory went.

use serde::Serialize;

/// One kernel's share of the time.
#[derive(Debug, Clone, Serialize)]
pub struct PassStats {
    /// Name of the kernel.
    pub name: String,
    /// Milliseconds on the device; 0 without timestamps.
    pub milliseconds: f64,
    /// Of all passes' time, 0 to 1.
    pub share: f64,
    /// How often it was dispatched.
    pub dispatches: u64,
}

/// Figures of a render so far.
#[derive(Debug, Clone, Serialize)]
pub struct Stats {
    /// Passes in the order in which a wave runs them.
    pub passes: Vec<PassStats>,
    /// Rays traced: paths, shadow and ambient occlusion.
    pub rays: u64,
    /// Of these, shadow rays: to any hit.
    pub shadow_rays: u64,
    /// Of these, ambient occlusion.
    pub ao_rays: u64,
    /// Million rays per second of the time spent in traversal (of wall time, without timestamps).
    pub mrays_per_second: f64,
    /// Camera paths finished per second of wall time.
    pub samples_per_second: f64,
    /// Wall time spent in rendering, seconds.
    pub seconds: f64,
    /// Samples that were not finite and count as black.
    pub invalid_samples: u64,
    /// Samples that were brighter than 2^31 and were clamped to that: see [`crate::film`].
    pub clamped_samples: u64,
    /// A texture whose loops ran so long that they were ended early.
    pub endless_texture: Option<String>,
    /// Bytes of GPU memory by purpose.
    pub memory: Vec<(String, u64)>,
    /// Pipelines created since the device was opened.
    pub pipelines_created: u64,
    /// Shader modules created since the device was opened.
    pub shader_modules_created: u64,
    /// Whether passes were timed on the device.
    pub timestamps: bool,
}
