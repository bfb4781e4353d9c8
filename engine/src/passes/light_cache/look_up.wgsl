// Ends paths in the cache, or, while it learns, notes from where they go on. One thread for each active path, whose ray has been
// traced; before any texture runs.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/materials.wgsl
//!include shared/images.wgsl
//!include shared/surface.wgsl
//!include shared/shadow_rays.wgsl
//!include light_cache/cells.wgsl

// How much wider than a cell a path must have become, as areas: where it is narrower, as behind a mirror or in a corner, one would
// see the cells. After Müller et al., "Real-time Neural Radiance Caching for Path Tracing", 2021, equations 3 and 4, for one segment.
const LEAST_SPREAD = 4.0;
// Surfaces that are smoother scatter other light to other places.
const LEAST_ROUGHNESS = 0.3;

// Whether all that a surface scatters can stand for what it scatters along one ray.
fn is_cached(triangle: vec4u) -> bool {
    let material = triangle.w & TRIANGLE_MATERIAL;
    let flags = materials[material].flags;
    let passes = (triangle.w & (TRIANGLE_PROGRAM_ALPHA | TRIANGLE_ALPHA)) != 0u
        || (flags & (MATERIAL_SOLID | MATERIAL_CLEAR | MATERIAL_UNLIT)) != 0u
        || materials[material].transmission > 0.0 || materials[material].diffuse_transmission > 0.0;
    return !passes && (materials[material].roughness >= LEAST_ROUGHNESS || materials[material].metallic < 0.5);
}

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
    if (hit.triangle == MISS || throughput.w <= 0.0 || state.z >= frame.max_depth || waits_for_program(slot)) {
        return;
    }
    let record = light_cache_settings.record;
    let learns = light_cache_settings.learns != 0u;
    if (learns && (path_words(record + 1u, slot).w & RECORD_STATE) != RECORD_NONE) {
        return; // the first place that a path can be learned from is what it would end at
    }
    if (!is_cached(triangles[hit.triangle]) || any(path_words(PATH_MEDIA, slot) != vec4u(0u))) {
        return;
    }
    let s = surface_at(hit);
    let side = cell_side(s.position);
    let spread = hit.t_max * hit.t_max / (throughput.w * max(dot(s.geometric_normal, s.wo), 1e-3));
    if (!(spread > LEAST_SPREAD * side * side)) {
        return;
    }
    // Cells are looked up, and learn, all around: no border shows.
    let id = path_id(slot);
    let turned = independent2(id.sample, hash2(id.key, 0x1f123bb5u + state.z)) - 0.5;
    let tangent = any_perpendicular(s.geometric_normal);
    let offset = side * (turned.x * tangent + turned.y * cross(s.geometric_normal, tangent));
    let cell = cell_at(s.position + offset, s.geometric_normal, side, learns);
    if (learns) {
        let wider = cell_at(s.position + WIDER * offset, s.geometric_normal, WIDER * side, true);
        path_set_words(record, slot, vec4u(cell, bitcast<vec3u>(throughput.xyz)));
        path_set_words(record + 1u, slot, vec4u(0u, 0u, 0u, select(wider, NO_WIDER_CELL, wider == NO_CELL) | RECORD_BEGUN));
        return;
    }
    var mean = cell_mean(cell);
    if (mean.w == 0.0) {
        mean = cell_mean(cell_at(s.position + WIDER * offset, s.geometric_normal, WIDER * side, false));
        if (mean.w == 0.0) {
            return;
        }
    }
    let gathered = path_read(PATH_RADIANCE, slot);
    let found = limited(throughput.xyz * mean.xyz, f32(state.z + 1u));
    path_write(PATH_RADIANCE, slot, vec4f(gathered.xyz + found, gathered.w));
    // As if it had scattered as often as it may: what the surface emits is all that is left to be found.
    path_set_words(PATH_STATE, slot, vec4u(state.xy, frame.max_depth, state.w));
}
