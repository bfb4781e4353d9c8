//! Hands queues from producers to consumers and sizes the dispatches that follow. One thread.

use super::pass::Pass;

/// Behind raygen.
pub const AFTER_RAYGEN: Pass = Pass {
    name: "advance_start",
    file: "advance/advance.wgsl",
    writes: &["dispatch_sizes", "queues"],
    ..Pass::COMMON
};

/// Behind classify.
pub const AFTER_CLASSIFY: Pass = Pass {
    name: "advance_texture",
    reads: &["ao_tables"],
    exists: |features| features.programs,
    ..AFTER_RAYGEN
};

/// Behind brdf.
pub const AFTER_BRDF: Pass = Pass {
    name: "advance_bounce",
    ..AFTER_RAYGEN
};

/// Behind gather_first_hit.
pub const AFTER_FIRST_HIT: Pass = Pass {
    name: "advance_followed",
    exists: |features| features.irradiance_cache,
    ..AFTER_RAYGEN
};
