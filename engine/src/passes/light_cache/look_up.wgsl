// Ends paths in the cache, or, while it learns, notes from where they go on. One thread for each active path, whose ray has been
// traced; before any texture runs.
//!include shared/found_light.wgsl
//!include light_cache/ends.wgsl

@compute @workgroup_size(64)
fn look_up_light(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                 @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let hit = rays[own_ray(slot)];
    let throughput = path_read(PATH_THROUGHPUT, slot); // with the pdf of the ray's direction, 0 from the camera
    let state = path_words(PATH_STATE, slot);
    let learns = light_cache_settings.mode == LIGHT_CACHE_LEARNS;
    if (light_cache_settings.mode == LIGHT_CACHE_IDLE || hit.triangle == MISS || throughput.w <= 0.0
        || path_is_last(slot) || waits_for_program(slot)) {
        return;
    }
    let record = light_cache_settings.record;
    // Most paths that told the cells had scattered once before. One that has twice may go on from here once less.
    let ends = light_cache_settings.ends != 0u && state.z == 2u;
    let begins = learns && path_words(record + 1u, slot).w == RECORD_NONE;
    if (learns && !begins && !ends) {
        return; // the first place that a path can be learned from is what it would end at
    }
    let place = end_at(slot, hit, state.z);
    if (!place.is_one) {
        return;
    }
    if (begins) {
        let cell = cell_of_place(place, begins_cells(path_id(slot)));
        path_set_words(record, slot, vec4u(cell, bitcast<vec3u>(throughput.xyz)));
        path_set_words(record + 1u, slot, vec4u(0u, 0u, 0u, RECORD_BEGUN));
        return;
    }
    let mean = known_mean(place, select(0u, light_cache_settings.lesser, learns));
    if (mean.w == 0.0) {
        return;
    }
    let gathered = path_read(PATH_RADIANCE, slot);
    let found = limited(throughput.xyz * mean.xyz, f32(state.z + 1u));
    path_write(PATH_RADIANCE, slot, vec4f(gathered.xyz + found, gathered.w));
    if (light_cache_settings.photons != 0u) {
        // What a surface scatters is no light that photons may have brought, as what it emits may be.
        let kept = path_words(light_cache_settings.photons, slot);
        path_set_words(light_cache_settings.photons, slot, vec4u(bitcast<vec3u>(bitcast<vec3f>(kept.xyz) + found), kept.w));
    }
    if (splits_light) {
        path_set_words(path_ended(), slot, vec4u(bitcast<vec3u>(found), found_word(state.z + 1u, true, NO_GROUP)));
    }
    // What the surface emits is all that is left to be found.
    path_set_words(PATH_STATE, slot, vec4u(state.xy, state.z | PATH_ENDS, state.w));
}
