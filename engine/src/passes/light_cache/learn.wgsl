// What paths have found that went on from a cell.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include light_cache/cells.wgsl

// What the surface in the cell has scattered, of a path's radiance; in w 0 where the path doesn't say. That it isn't finite its bits tell:
// it is dropped then, as it is from the film. So is a path of which hardly anything of one colour came as far, by a pure red wall or
// as one hue of many: it says nothing of that colour here, and what it says of the others a cell can't count apart. What it carries is
// decided before the cell, so that the mean of the others stays right.
fn scattered_from(slot: u32, radiance: vec3f) -> vec4f {
    let field = light_cache_settings.record;
    let found = radiance - bitcast<vec3f>(path_words(field + 1u, slot).xyz);
    let throughput = bitcast<vec3f>(path_words(field, slot).yzw);
    let least = 1e-3 * max(max(throughput.x, throughput.y), throughput.z);
    let says = all(throughput > vec3f(least));
    let scattered = max(found / throughput, vec3f(0.0));
    let is_finite = all((bitcast<vec3u>(scattered) & vec3u(0x7f800000u)) != vec3u(0x7f800000u));
    return select(vec4f(0.0), vec4f(scattered, 1.0), is_finite && says);
}

// Tells a path's cell so; `lesser` as for `cell_mean`.
fn tell(slot: u32, scattered: vec4f, lesser: u32) {
    if (scattered.w == 0.0) {
        return;
    }
    let cell = path_words(light_cache_settings.record, slot).x;
    if (cell != NO_CELL) {
        cell_add(cell + lesser, scattered.xyz);
    }
}

// Whether paths go on to their end, and say what goes on once less.
fn tells_lesser() -> bool {
    return light_cache_settings.ends == 0u;
}

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
    let known_as = path_words(field, slot).w;
    if (known_as == RECORD_BEGUN) {
        var before = path_read(PATH_RADIANCE, slot).xyz;
        if (light_cache_settings.photons != 0u) {
            // What photons bring to the cell's own surface, it scatters.
            before -= path_read(PATH_DIFFUSE, slot).xyz;
        }
        path_set_words(field, slot, vec4u(bitcast<vec3u>(before), RECORD_KNOWN));
    }
    if (known_as != RECORD_NONE && known_as != RECORD_DEEP && tells_lesser() && path_is_last(slot)) {
        // What has been scattered less often is all found by now.
        tell(slot, scattered_from(slot, path_read(PATH_RADIANCE, slot).xyz), light_cache_settings.lesser);
        path_set_words(field, slot, vec4u(path_words(field, slot).xyz, RECORD_DEEP));
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
    let state = path_words(field + 1u, slot).w;
    let is_deep = state == RECORD_DEEP;
    var scattered = vec4f(0.0);
    if (is_deep || state == RECORD_KNOWN) {
        var radiance = path_read(PATH_RADIANCE, slot).xyz;
        let is_known = !has_program_shadows || path_words(PATH_LIGHT_POINT, slot).x == MISS;
        if (rays[shadow_ray(slot)].triangle == MISS && is_known) {
            // The light sample of the last vertex, which nothing has counted yet.
            radiance += waiting_light(slot, path_depth(slot) + 1u);
        }
        scattered = scattered_from(slot, radiance);
    }
    tell(slot, scattered, 0u);
    if (tells_lesser() && !is_deep) {
        tell(slot, scattered, light_cache_settings.lesser);
    }
    path_set_words(field + 1u, slot, vec4u(0u)); // for the slot's next path
}
