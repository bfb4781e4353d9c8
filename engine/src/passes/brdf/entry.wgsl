// One vertex of every active path.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include brdf/brdf.wgsl

@compute @workgroup_size(64)
fn brdf(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
        @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    shade_vertex(queue_read(QUEUE_ACTIVE, index));
}
