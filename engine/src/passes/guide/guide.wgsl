// Keeps what the camera's rays hit first, for a window to show. One thread per path of a wave of one sample.
//!include shared/wave_memory.wgsl
//!include shared/geometry.wgsl
//!include shared/surface.wgsl

// Distance, material, instance (both MISS where nothing was hit) and the octahedral shading normal of each pixel.
@group(0) @binding(5) var<storage, read_write> guides: array<vec4u>;

@compute @workgroup_size(64)
fn guide(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
         @builtin(local_invocation_index) local: u32) {
    let slot = thread_index(workgroup, workgroups, local);
    if (slot >= frame.wave_size) {
        return;
    }
    let pixel = pixel_coordinates(path_id(slot).pixel);
    if (!is_rendered(pixel)) {
        return;
    }
    let at = pixel.y * frame.width + pixel.x;
    if (rays[slot].triangle == MISS) {
        guides[at] = vec4u(bitcast<u32>(1e30), MISS, MISS, 0u);
        return;
    }
    let surface = surface_at(rays[slot]);
    guides[at] = vec4u(
        bitcast<u32>(rays[slot].t_max),
        surface.triangle.w & TRIANGLE_MATERIAL,
        instances[rays[slot].instance].source,
        octahedral_encode(surface.shading_normal));
}
