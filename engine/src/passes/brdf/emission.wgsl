// Light that a path's rays have found: by the shadow ray of the vertex before, and by its own ray.
//!include shared/environment.wgsl
//!include shared/lights.wgsl
//!include shared/estimator.wgsl
//!include shared/shadow_rays.wgsl
//!include brdf/split.wgsl

// How much passes is part of PATH_LIGHT by now: the shadow ray goes on behind that surface, and the path waits for it.
fn follow_shadow_ray(slot: u32, hit: RayHit) {
    rays[shadow_ray(slot)].triangle = MISS;
    if (max_component(path_read(PATH_LIGHT, slot).xyz) > 0.0) {
        queue_append(QUEUE_SHADOW, slot);
    } else {
        path_set_words(PATH_LIGHT_POINT, slot, vec4u(MISS, 0u, 0u, 0u));
    }
    rays[own_ray(slot)].t_max = select(1e30, DEAD, hit.t_max < 0.0);
    rays[own_ray(slot)].triangle = MISS;
    queue_append(QUEUE_ACTIVE, slot);
}

// The radiance with the light sample of the previous vertex, unless something is in its way.
fn with_light_sample(p: Path) -> vec3f {
    if (rays[shadow_ray(p.slot)].triangle == MISS) {
        return p.radiance + waiting_light(p.slot, p.depth);
    }
    return p.radiance;
}

// The radiance with that of the environment and of lamps infinitely far away, which the ray has escaped to. `receiver_before` is what
// light samples know of the vertex before.
fn handle_escaped_ray(p: Path, hit: RayHit, receiver_before: u32) -> vec3f {
    if (has_program_shadows && hit.t_max < 0.0) {
        return p.radiance; // it only waited for its shadow ray
    }
    var weight = 1.0;
    let shares = light_shares(hit.origin, receiver_before, p.id);
    if (has_environment && p.bsdf_pdf > 0.0) {
        weight = met_light_weight(p.bsdf_pdf, sky_pdf(hit.origin, hit.direction, receiver_before, shares));
    }
    let radiance = environment_radiance(hit.direction);
    if (leaves_diffuse) {
        leave_sky(p, radiance);
    }
    let sky = radiance * weight;
    let disks = disk_radiance(hit.direction, p.bsdf_pdf, shares.other);
    if (splits_light) {
        // Clamped as one, as it is for the picture.
        let all = p.throughput * (sky + disks.radiance);
        let factor = limited(all, f32(p.depth)) / max(all, vec3f(1e-37));
        note_found(p, PATH_FOUND, p.throughput * sky * factor, false, frame.environment_group);
        note_found(p, PATH_FOUND_DISKS, p.throughput * disks.radiance * factor, false, disks.group);
    }
    return p.radiance + limited(p.throughput * (sky + disks.radiance), f32(p.depth));
}

// The radiance with what the surface emits.
fn handle_emissive_intersection(p: Path, v: Vertex, hit: RayHit, receiver_before: u32, texel: vec4f) -> vec3f {
    // The base of a blend says whether there is a back, as it does for rays and light samples.
    if (!v.surface.front && (materials[v.own_material].flags & MATERIAL_DOUBLE_SIDED) == 0u) {
        return p.radiance;
    }
    let emission = emission_at(p.slot, v.driven, v.material, texel);
    var weight = 1.0;
    if (p.bsdf_pdf > 0.0 && materials[v.own_material].light_radiance > 0.0 && max_component(emission) > 0.0) {
        let cosine = max(dot(v.surface.geometric_normal, v.surface.wo), 1e-7);
        let share = light_shares(hit.origin, receiver_before, p.id).other;
        weight = met_light_weight(p.bsdf_pdf, light_hit_pdf(hit, receiver_before, cosine, share));
    }
    let found = limited(p.throughput * emission * weight, f32(p.depth));
    leave_unsent(p, v, found);
    if (splits_light) {
        note_found(p, PATH_FOUND, found, true, light_group(materials[v.own_material].flags));
    }
    return p.radiance + found;
}
