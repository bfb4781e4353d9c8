// Traces the rays of a queue: `traverse_closest` the paths' own rays, `traverse_occlusion` their shadow rays.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/queues.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/traversal.wgsl

@compute @workgroup_size(64)
fn traverse_closest(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                    @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let hit = trace(rays[slot].origin, rays[slot].direction, rays[slot].t_min, rays[slot].t_max, false, MISS);
    rays[slot].t_max = hit.t;
    rays[slot].barycentrics = hit.barycentrics;
    rays[slot].triangle = hit.triangle;
    rays[slot].instance = hit.instance;
}

@compute @workgroup_size(64)
fn traverse_occlusion(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                      @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_SHADOW)) {
        return;
    }
    let slot = frame.capacity + queue_read(QUEUE_SHADOW, index);
    let hit = trace(rays[slot].origin, rays[slot].direction, rays[slot].t_min, rays[slot].t_max, true, MISS);
    rays[slot].triangle = hit.triangle;
    if (hit.triangle != MISS && (triangles[hit.triangle].w & TRIANGLE_PROGRAM_ALPHA) != 0u) {
        // A texture program decides how much passes. Then the ray goes on from here.
        rays[slot].t_min = hit.t;
        rays[slot].barycentrics = hit.barycentrics;
        rays[slot].instance = hit.instance;
    }
}
