// Ambient occlusion for the hits whose texture program reads it: one thread per ray, all rays of all hits at once.
// Each occluded ray adds one to its table's eight bits of the slot's word.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/queues.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/surface.wgsl
//!include shared/traversal.wgsl
//!include shared/ao_tables.wgsl

@compute @workgroup_size(64)
fn ao(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
      @builtin(local_invocation_index) local: u32) {
    var samples = 0u;
    for (var i = 0u; i < 4u; i++) {
        samples = max(samples, ao_tables[i].samples);
    }
    let index = thread_index(workgroup, workgroups, local);
    let entry_index = index / max(samples, 1u);
    let sample = index % max(samples, 1u);
    if (entry_index >= queue_length(QUEUE_AO)) {
        return;
    }
    let entry = queue_read(QUEUE_AO, entry_index);
    let ray = entry & ENTRY_RAY;
    let hit = rays[ray];
    let s = surface_at(hit);
    let is_shadow = ray >= frame.capacity;
    let slot = select(ray, ray - frame.capacity, is_shadow);
    let path = path_id(slot);
    let tangent = any_perpendicular(s.shading_normal);
    let bitangent = cross(s.shading_normal, tangent);
    let purpose = vertex_dimension(path_depth(slot), select(DIMENSION_AO, DIMENSION_SHADOW_AO, is_shadow));
    for (var i = 0u; i < 4u; i++) {
        let table = ao_tables[i];
        if (((entry >> (28u + i)) & 1u) == 0u || sample >= table.samples) {
            continue;
        }
        // Consecutive points of one sequence: well spread within a hit and over the samples of a pixel.
        let stream = hash2(path.pixel ^ frame.seed, purpose + i);
        let u = sobol2(path.sample * table.samples + sample, stream);
        let radius = sqrt(u.x);
        let phi = 6.28318530718 * u.y;
        let height = sqrt(max(1.0 - u.x, 1e-12));
        var direction = tangent * (radius * cos(phi)) + bitangent * (radius * sin(phi)) + s.shading_normal * height;
        var normal = s.geometric_normal;
        if (table.direction == AO_INSIDE || (table.direction == AO_BOTH && (sample & 1u) == 1u)) {
            direction = -direction;
            normal = -normal;
        }
        if (dot(direction, normal) <= 0.0) {
            // Under the surface because the shading normal leans: counts as free.
            continue;
        }
        let only_instance = select(MISS, hit.instance, table.same_object != 0u);
        let occluder = trace(offset_origin(s.position, normal), direction, 0.0, table.distance, true, only_instance);
        atomicAdd(&queues[WORD_AO_RAYS], 1u);
        if (occluder.triangle != MISS) {
            atomicAdd(&queues[ao_word(ray)], 1u << (8u * i));
        }
    }
}
