// Traces the rays of a queue: `traverse_closest` the paths' own rays, `traverse_occlusion` their shadow rays.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include shared/traversal.wgsl
//!include traverse/traverse.wgsl

@compute @workgroup_size(64)
fn traverse_closest(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                    @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    find_closest(queue_read(QUEUE_ACTIVE, index));
}

@compute @workgroup_size(64)
fn traverse_occlusion(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                      @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_SHADOW)) {
        return;
    }
    find_occluder(queue_read(QUEUE_SHADOW, index));
}
