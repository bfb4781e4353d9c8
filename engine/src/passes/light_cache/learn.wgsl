// What paths have found that went on from a cell.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include light_cache/cells.wgsl

// After the vertex in the cell: what a path has by then comes from before. One thread for each path that was active.
@compute @workgroup_size(64)
fn note_light(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
              @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (light_cache_settings.mode != LIGHT_CACHE_LEARNS || index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let field = light_cache_settings.record + 1u;
    let state = path_words(field, slot).w;
    if ((state & RECORD_STATE) == RECORD_BEGUN) {
        var before = path_read(PATH_RADIANCE, slot).xyz;
        if (light_cache_settings.photons != 0u) {
            // What photons bring to the cell's own surface, it scatters.
            before -= path_read(PATH_DIFFUSE, slot).xyz;
        }
        path_set_words(field, slot, vec4u(bitcast<vec3u>(before), (state & ~RECORD_STATE) | RECORD_KNOWN));
    }
}

// At the end of a wave. One thread for each path.
@compute @workgroup_size(64)
fn learn_light(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
               @builtin(local_invocation_index) local: u32) {
    let slot = thread_index(workgroup, workgroups, local);
    if (light_cache_settings.mode != LIGHT_CACHE_LEARNS || slot >= frame.wave_size) {
        return;
    }
    let field = light_cache_settings.record;
    let before = path_words(field + 1u, slot);
    path_set_words(field + 1u, slot, vec4u(0u)); // for the slot's next path
    if ((before.w & RECORD_STATE) != RECORD_KNOWN) {
        return;
    }
    var found = path_read(PATH_RADIANCE, slot).xyz - bitcast<vec3f>(before.xyz);
    let is_known = !has_program_shadows || path_words(PATH_LIGHT_POINT, slot).x == MISS;
    if (rays[shadow_ray(slot)].triangle == MISS && is_known) {
        // The light sample of the last vertex, which nothing has counted yet.
        found += waiting_light(slot, path_depth(slot) + 1u);
    }
    let record = path_words(field, slot);
    let throughput = bitcast<vec3f>(record.yzw);
    // A colour that hardly anything comes through says nothing of what was there.
    let least = 1e-3 * max(max(throughput.x, throughput.y), throughput.z);
    let scattered = select(vec3f(0.0), found / throughput, throughput > vec3f(least));
    // What isn't finite is dropped, as it is from the film; its bits tell.
    if (all((bitcast<vec3u>(max(scattered, vec3f(0.0))) & vec3u(0x7f800000u)) != vec3u(0x7f800000u))) {
        cell_add(record.x, scattered);
        let wider = before.w & ~RECORD_STATE;
        cell_add(select(wider, NO_CELL, wider == NO_WIDER_CELL), scattered);
    }
}
