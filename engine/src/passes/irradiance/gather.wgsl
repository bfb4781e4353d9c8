// Gather rays: from a record to all sides, to see what the surfaces there scatter towards it. They are paths of a wave like others,
// which begin at the record instead of the camera and end in a list instead of the film.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/left.wgsl
//!include shared/found_light.wgsl
//!include photons/states.wgsl
//!include irradiance/records.wgsl

@group(0) @binding(51) var<storage, read> irradiance_records: array<vec4u>;
// What the rays of each stratum have found: sums of radiance, and of one over the distance.
@group(0) @binding(55) var<storage, read_write> irradiance_gathered: array<vec4f>;

// What a path keeps meanwhile in its field `gather`: radiance that a cache gave for the first surface, and the distance so far; in
// the next one, what has become of it.
const GATHER_FLIES = 0u; // it has met nothing yet
const GATHER_GIVEN = 1u; // a cache knew the surface
const GATHER_FOLLOWED = 2u; // a path goes on from there

// The number of a path's ray among those of all records, if each had as many as those of this pass.
fn gather_ray(slot: u32) -> u32 {
    return frame.first_sample * frame.padded_pixels + frame.first_pixel + slot;
}

@compute @workgroup_size(64)
fn gather_start(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                @builtin(local_invocation_index) local: u32) {
    let slot = thread_index(workgroup, workgroups, local);
    if (slot >= frame.wave_size) {
        return;
    }
    let ray = gather_ray(slot);
    let record = ray / gather_rays();
    path_set_words(irradiance_settings.gather, slot, vec4u(0u));
    path_set_words(irradiance_settings.gather + 1u, slot, vec4u(0u));
    if (irradiance_settings.photons != 0u) {
        // Photons have brought what casters throw on the record's place.
        path_set_words(irradiance_settings.photons, slot, vec4u(0u, 0u, 0u, PATH_IS_DIFFUSE));
        let all = shares_words(vec3f(1.0), true, 0u);
        path_set_words(irradiance_settings.photons + 1u, slot, vec4u(all, 0u, 0u));
    }
    path_write(PATH_LIGHT, slot, vec4f(0.0));
    path_set_words(PATH_STATE, slot, vec4u(0u, 0u, 1u, 0u));
    path_set_words(PATH_MEDIA, slot, vec4u(0u));
    path_set_words(PATH_LIGHT_POINT, slot, vec4u(MISS, 0u, 0u, 0u));
    rays[shadow_ray(slot)].triangle = MISS;
    path_write(PATH_RADIANCE, slot, vec4f(0.0));
    if (record >= irradiance_settings.end_record) {
        return;
    }
    let place = irradiance_records[record * RECORD_WORDS];
    let width = bitcast<f32>(irradiance_records[record * RECORD_WORDS + 8u].w);
    path_write(PATH_RADIANCE, slot, vec4f(0.0, 0.0, 0.0, width));
    let stratum = ray % gather_rays();
    let ring = stratum / irradiance_settings.sectors;
    let sector = stratum % irradiance_settings.sectors;
    // Neighbours, whose numbers follow each other, see about the same, and are smoothed by each other: so all records share the points
    // of a stratum, which follow each other turn by turn and record by record.
    let inside = sobol2(record * irradiance_settings.turns + irradiance_settings.turn, hash2(irradiance_settings.points, stratum));
    let sine2 = (f32(ring) + inside.x) / f32(irradiance_settings.rings);
    let cosine = sqrt(max(1.0 - sine2, 0.0));
    let around = unit_circle((f32(sector) + inside.y) / f32(irradiance_settings.sectors)) * sqrt(sine2);
    let normal = octahedral_decode(irradiance_records[record * RECORD_WORDS + 1u].w);
    let tangent = any_perpendicular(normal);
    let direction = normalize(tangent * around.x + cross(normal, tangent) * around.y + normal * cosine);
    rays[own_ray(slot)] = RayHit(bitcast<vec3f>(place.xyz), 0.0, direction, 1e30, vec2f(0.0), MISS, 0u);
    path_write(PATH_THROUGHPUT, slot, vec4f(1.0, 1.0, 1.0, max(cosine, 1e-3) * 0.318309886));
    queue_append(QUEUE_ACTIVE, slot);
}

// After the shading of a vertex. One thread for each path that was active.
@compute @workgroup_size(64)
fn gather_note(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
               @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    if (irradiance_settings.photons == 0u) {
        path_set_words(PATH_LEFT, slot, vec4u(0u)); // else their pass needs it
    }
    let field = irradiance_settings.gather;
    if (path_words(field + 1u, slot).w == GATHER_FLIES && path_depth(slot) >= 2u) {
        // What the surface emits by itself is no business of the cache.
        path_set_words(field + 1u, slot, vec4u(0u, 0u, 0u, GATHER_FOLLOWED));
        let gathered = path_read(PATH_RADIANCE, slot);
        path_write(PATH_RADIANCE, slot, vec4f(0.0, 0.0, 0.0, gathered.w));
    }
}

// At the end of a wave. One thread for each path.
@compute @workgroup_size(64)
fn gather_end(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
              @builtin(local_invocation_index) local: u32) {
    let slot = thread_index(workgroup, workgroups, local);
    if (slot >= frame.wave_size) {
        return;
    }
    let field = irradiance_settings.gather;
    let kept = path_read(field, slot);
    let state = path_words(field + 1u, slot).w;
    // For the slot's next path.
    path_set_words(field, slot, vec4u(0u));
    path_set_words(field + 1u, slot, vec4u(0u));
    path_set_words(PATH_LEFT, slot, vec4u(0u));
    let ray = gather_ray(slot);
    if (ray / gather_rays() >= irradiance_settings.end_record) {
        return;
    }
    var found = kept.xyz;
    if (state != GATHER_GIVEN) {
        found = select(vec3f(0.0), path_read(PATH_RADIANCE, slot).xyz, state == GATHER_FOLLOWED);
        let is_known = !has_program_shadows || path_words(PATH_LIGHT_POINT, slot).x == MISS;
        if (rays[shadow_ray(slot)].triangle == MISS && is_known) {
            found += waiting_light(slot, path_depth(slot) + 1u);
        }
    }
    // What isn't finite is dropped; its bits tell.
    let is_finite = all((bitcast<vec3u>(max(found, vec3f(0.0))) & vec3u(0x7f800000u)) != vec3u(0x7f800000u));
    var sum = vec4f(select(vec3f(0.0), max(found, vec3f(0.0)), is_finite), 1.0 / max(kept.w, 1e-6));
    let place = ray - irradiance_settings.first_record * gather_rays();
    if (irradiance_settings.turn > 0u) {
        sum += irradiance_gathered[place];
    }
    irradiance_gathered[place] = sum;
}
