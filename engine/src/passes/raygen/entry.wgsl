// Starts every path of the wave.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include raygen/raygen.wgsl

@compute @workgroup_size(64)
fn raygen(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
          @builtin(local_invocation_index) local: u32) {
    let slot = thread_index(workgroup, workgroups, local);
    if (slot >= frame.wave_size) {
        return;
    }
    start_path(slot);
}
