// Photons start: at a lamp, towards what throws caustics. A point of a lamp is first a hit like others, so that its texture
// program says what it emits.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/media.wgsl
//!include shared/surface.wgsl
//!include shared/appearance.wgsl
//!include shared/environment.wgsl
//!include shared/lights.wgsl
//!include shared/estimator.wgsl
//!include photons/targets.wgsl

@group(0) @binding(57) var<storage, read> photon_lights: array<vec2u>;

// The bodies that a light with a place is in, as a path has them. They come behind what belongs to each light, the environment
// included whether it has photons or not.
fn lamp_media(index: u32) -> vec4u {
    let at = photon_settings.light_count + photon_settings.directional_count + 1u + 2u * index;
    return vec4u(photon_lights[at], photon_lights[at + 1u]);
}

// The light of a share of all weights.
fn choose_photon_light(share: f32) -> u32 {
    var low = 0u;
    var high = all_lights() - 1u;
    let wanted = share * bitcast<f32>(photon_lights[high].y);
    while (low < high) {
        let middle = (low + high) / 2u;
        if (bitcast<f32>(photon_lights[middle].y) > wanted) {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    return low;
}

// Sends the photon off, with flux in units of what it has on average.
fn send_photon(slot: u32, aim: Aim, flux: vec3f, range: f32) {
    if (!(max_component(flux) > 0.0)) {
        return;
    }
    path_set_words(photon_settings.field, slot, vec4u(bitcast<u32>(range), 0u, medium_among(path_words(PATH_MEDIA, slot)), 0u));
    path_write(PATH_THROUGHPUT, slot, vec4f(flux, 1.0));
    rays[own_ray(slot)] = RayHit(aim.origin, 0.0, aim.direction, 1e30, vec2f(0.0), MISS, 0u);
    queue_append(QUEUE_ACTIVE, slot);
}

@compute @workgroup_size(64)
fn photon_start(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                @builtin(local_invocation_index) local: u32) {
    let slot = thread_index(workgroup, workgroups, local);
    if (slot >= frame.wave_size) {
        return;
    }
    path_set_words(photon_settings.field, slot, vec4u(0u));
    path_set_words(PATH_LEFT, slot, vec4u(0u));
    path_write(PATH_LIGHT, slot, vec4f(0.0));
    path_set_words(PATH_STATE, slot, vec4u(0u));
    path_set_words(PATH_MEDIA, slot, vec4u(0u));
    path_set_words(PATH_LIGHT_POINT, slot, vec4u(MISS, 0u, 0u, 0u));
    path_write(PATH_RADIANCE, slot, vec4f(0.0));
    rays[shadow_ray(slot)].triangle = MISS;
    let number = frame.first_sample * frame.padded_pixels + frame.first_pixel + slot;
    if (number >= photon_settings.photons || photon_settings.target_count == 0u || all_lights() == 0u) {
        return;
    }
    let seed = photon_settings.seed;
    let u = sobol4(number, hash2(seed, 1u), 0u, hash2(seed, 2u));
    let choice = sobol2(number, hash2(seed, 3u));
    let index = choose_photon_light(choice.x);
    let weight = bitcast<f32>(photon_lights[index].x);
    if (!(weight > 0.0)) {
        return;
    }
    if (index >= photon_settings.light_count + photon_settings.directional_count) {
        let sampled = environment_sample(u.xy);
        let aim = aim_along(-sampled.wi, choice.y, u.zw);
        if (sampled.pdf > 0.0) {
            send_photon(slot, aim, sampled.radiance * (aim.weight / (sampled.pdf * weight)), 0.0);
        }
        return;
    }
    let light = light_at(index);
    if (index < photon_settings.light_count) {
        path_set_words(PATH_MEDIA, slot, lamp_media(index));
    } else {
        let extent = light.position[DISTANT_EXTENT];
        // Uniform over the disk in the sky, if it is one.
        let height = u.x * extent;
        let tangent = any_perpendicular(light.direction);
        let around = unit_circle(u.y) * sqrt(height * (2.0 - height));
        let direction = normalize(
            tangent * around.x + cross(light.direction, tangent) * around.y + light.direction * (1.0 - height));
        let aim = aim_along(direction, choice.y, u.zw);
        let spread = select(1.0, 2.0 * PI * extent, extent > 0.0);
        send_photon(slot, aim, light.intensity * (spread * aim.weight / weight), 0.0);
        return;
    }
    if (light.kind != LIGHT_TRIANGLE) {
        let aim = aim_from(light.position, choice.y, u.zw);
        var cone = 1.0;
        if (light.kind == LIGHT_SPOT) {
            cone = saturate((dot(light.direction, aim.direction) - light.spot_outer) * light.spot_scale);
        }
        send_photon(slot, aim, light.intensity * (cone * cone * aim.weight / weight), light.range);
        return;
    }
    let b = triangle_point(u.xy);
    let place = light.position + light.direction * b.x + light.intensity * b.y;
    let aim = aim_from(place, choice.y, u.zw);
    let normal = cross(light.direction, light.intensity);
    let area = 0.5 * length(normal);
    let cosine = dot(normal, aim.direction) / (2.0 * area) * instances[light.instance].handedness;
    let material = triangles[light.triangle].w & TRIANGLE_MATERIAL;
    if (cosine <= 0.0 && (materials[material].flags & MATERIAL_DOUBLE_SIDED) == 0u) {
        return;
    }
    path_write(PATH_THROUGHPUT, slot, vec4f(vec3f(abs(cosine) * area * aim.weight / weight), 1.0));
    rays[own_ray(slot)] = RayHit(place + aim.direction, 0.0, -aim.direction, 1.0, b, light.triangle, light.instance);
    queue_append(QUEUE_ACTIVE, slot);
}

// Once the programs of lamps have run. One thread for each photon.
@compute @workgroup_size(64)
fn photon_emit(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
               @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let hit = rays[own_ray(slot)];
    if (hit.triangle == MISS) {
        queue_append(QUEUE_ACTIVE, slot);
        return;
    }
    let s = surface_at(hit);
    let own = s.triangle.w & TRIANGLE_MATERIAL;
    var material = own;
    var driven = 0u;
    if (runs_program(materials[own].flags, frame.max_depth == 0u)) {
        let resolved = path_words(PATH_STATE, slot);
        material = resolved.x;
        driven = resolved.y;
        path_set_words(PATH_STATE, slot, vec4u(0u));
    }
    let texel = material_texture(material, TEXTURE_EMISSION, s.triangle, s.weights);
    var flux = path_read(PATH_THROUGHPUT, slot).xyz * emission_at(slot, driven, material, texel);
    if ((s.triangle.w & TRIANGLE_ALPHA) != 0u) {
        flux *= material_coverage(own, s.triangle, s.weights);
    }
    flux *= saturate(scalar_or(slot, driven, OUTPUT_OPACITY, 1.0));
    send_photon(slot, Aim(offset_origin(s.position, s.geometric_normal, s.coarseness), s.wo, 1.0), flux, 0.0);
}
