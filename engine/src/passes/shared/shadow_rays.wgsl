// What a path's shadow ray has come to.
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/geometry.wgsl

// Whether the shadow ray met a surface whose texture program lets some of it pass.
fn waits_for_program(slot: u32) -> bool {
    let blocker = rays[shadow_ray(slot)].triangle;
    return has_program_shadows && blocker != MISS && (triangles[blocker].w & TRIANGLE_PROGRAM_ALPHA) != 0u;
}
