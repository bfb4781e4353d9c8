// Where gather rays meet their first surface: what a cache knows of it is enough. One thread for each active path, whose ray has been
// traced; before any texture runs. Most of them end here, and shading, in lanes, takes as long for one of eight as for all: so those that
// go on are put together.
//!include light_cache/ends.wgsl
//!include irradiance/settings.wgsl

// The same as in gather.wgsl.
const GATHER_FLIES = 0u;
const GATHER_GIVEN = 1u;

// Notes what a path's ray has met, if that is its first; whether it was all that was to be found.
fn ends_here(slot: u32) -> bool {
    let field = irradiance_settings.gather;
    if (path_words(field + 1u, slot).w != GATHER_FLIES || waits_for_program(slot)) {
        return false;
    }
    let hit = rays[own_ray(slot)];
    if (hit.triangle == MISS) {
        path_write(field, slot, vec4f(0.0, 0.0, 0.0, 1e30));
        return true;
    }
    // The whole distance: behind a pane that it has passed, a ray still is where it began.
    path_write(field, slot, vec4f(0.0, 0.0, 0.0, hit.t_max));
    let place = end_at(slot, hit, 1u);
    if (!place.is_one) {
        return false;
    }
    let mean = known_mean(place, 0u);
    if (mean.w == 0.0) {
        return false;
    }
    path_write(field, slot, vec4f(mean.xyz, hit.t_max));
    path_set_words(field + 1u, slot, vec4u(0u, 0u, 0u, GATHER_GIVEN));
    return true;
}

@compute @workgroup_size(64)
fn gather_first_hit(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                    @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    if (!ends_here(slot)) {
        queue_append(QUEUE_ACTIVE, slot);
    }
}
