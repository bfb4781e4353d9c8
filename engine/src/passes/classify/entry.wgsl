// Sorts out the hits of every active path.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include classify/classify.wgsl

@compute @workgroup_size(64)
fn classify(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
            @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    classify_hits(queue_read(QUEUE_ACTIVE, index));
}
