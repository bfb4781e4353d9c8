// Where gather rays meet their first surface: what a cache knows of it is enough. One thread for each active path, whose ray has been
// traced; before any texture runs.
//!include light_cache/ends.wgsl
//!include irradiance/settings.wgsl

// The same as in gather.wgsl.
const GATHER_FLIES = 0u;
const GATHER_GIVEN = 1u;

@compute @workgroup_size(64)
fn gather_first_hit(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                    @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let field = irradiance_settings.gather;
    if (path_words(field + 1u, slot).w != GATHER_FLIES || waits_for_program(slot)) {
        return;
    }
    let hit = rays[own_ray(slot)];
    let before = path_read(field, slot).w;
    if (hit.triangle == MISS) {
        path_write(field, slot, vec4f(0.0, 0.0, 0.0, 1e30));
        return;
    }
    path_write(field, slot, vec4f(0.0, 0.0, 0.0, before + hit.t_max));
    let place = end_at(slot, hit, 1u);
    if (!place.is_one) {
        return;
    }
    let mean = known_mean(place);
    if (mean.w == 0.0) {
        return;
    }
    path_write(field, slot, vec4f(mean.xyz, before + hit.t_max));
    path_set_words(field + 1u, slot, vec4u(0u, 0u, 0u, GATHER_GIVEN));
    // Nothing of the surface is needed any more: a dead ray that has met nothing.
    path_set_words(PATH_THROUGHPUT, slot, vec4u(0u));
    rays[own_ray(slot)].triangle = MISS;
    rays[own_ray(slot)].t_max = -1.0;
}
