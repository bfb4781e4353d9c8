// Keeps what the table says as the former one. One thread for each cell.
//!include light_cache/cells.wgsl

@compute @workgroup_size(64)
fn keep_light(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
              @builtin(local_invocation_index) local: u32) {
    let cell = thread_index(workgroup, workgroups, local);
    if (cell > light_cache_settings.mask) {
        return;
    }
    for (var word = cell * CELL_WORDS; word < (cell + 1u) * CELL_WORDS; word++) {
        atomicStore(&light_cache[former_table() + word], atomicLoad(&light_cache[word]));
    }
}
