// Takes caustics from the map of photons. One thread for each active path, whose vertex has been shaded.
//
// Light is told apart by how it came to a surface that scatters diffusely: what casters alone have scattered since the lamp is the
// photons', all else the path's. So where a path's ray, having left such a surface, meets casters and then a lamp, or samples
// one from there, that counts as little as the surface's share in the ray was diffuse.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include shared/geometry.wgsl
//!include shared/found_light.wgsl
//!include shared/left.wgsl
//!include photons/look_up.wgsl

@group(0) @binding(57) var<storage, read> photon_lights: array<vec2u>;

// The irradiance of photons, W/m2, that at most so many casters have scattered.
fn photon_irradiance(position: vec3f, facing: vec3f, most_scattered: u32) -> vec3f {
    let flux = photon_flux(position, facing, most_scattered);
    let radius = photon_radius(position);
    let all = bitcast<f32>(photon_lights[all_lights() - 1u].y);
    return vec3f(flux) * (all / (FLUX_SCALE * f32(photon_settings.photons) * 3.14159265 * radius * radius));
}

@compute @workgroup_size(64)
fn gather_photons(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                  @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let left = path_words(PATH_LEFT, slot);
    path_set_words(PATH_LEFT, slot, vec4u(0u));
    let unsent = path_read(PATH_UNSENT, slot).xyz;
    let has_unsent = max(max(unsent.x, unsent.y), unsent.z) > 0.0;
    if (has_unsent) {
        path_set_words(PATH_UNSENT, slot, vec4u(0u));
    }
    if (photon_settings.mode == PHOTONS_IDLE) {
        return;
    }
    let kind = left.w & LEFT_KIND;
    let goes_on = (left.w & LEFT_ON) != 0u;
    let before = select(path_depth(slot), left.z, kind != LEFT_NONE && kind != LEFT_SKY);
    let field = photon_settings.field;
    let gathered = path_read(PATH_RADIANCE, slot);
    var radiance = gathered.xyz;
    var is = PATH_IS_FREE;
    var photons = vec2u(0u); // of the light sample: see `path_given_shares`
    if (before > 0u) {
        let kept = path_words(field, slot);
        is = kept.w;
        if (is == PATH_IS_CAUSTIC) {
            // Of what no photons come from all is the path's.
            radiance = with_less(bitcast<vec3f>(kept.xyz) + unsent, radiance, slot);
            if (splits_light) {
                if (!has_unsent) {
                    take_photons_part(slot, PATH_FOUND);
                }
                take_photons_part(slot, PATH_FOUND_DISKS);
            }
            if (kind == LEFT_SKY && photon_settings.environment == 0u) {
                // No photons come from an even sky: rays alone, which meet it often enough, bring all of its light.
                let sky = limited(bitcast<vec3f>(left.xyz) * shares_diffuse(path_words(field + 1u, slot).xy), f32(before));
                radiance += sky;
                if (splits_light) {
                    note_given(slot, sky, before, path_words(field + 1u, slot).z);
                }
            }
        }
    }
    var brought = vec3f(0.0);
    if (kind == LEFT_DIFFUSE) {
        let place = path_words(PATH_PLACE, slot);
        let diffuse = path_words(PATH_DIFFUSE, slot);
        if (left.z + 2u <= frame.max_depth) {
            let found = photon_irradiance(bitcast<vec3f>(place.xyz), octahedral_decode(place.w), frame.max_depth - left.z - 1u);
            brought = limited(bitcast<vec3f>(diffuse.xyz) * found, f32(left.z + 2u));
            radiance += brought;
            if (splits_light) {
                note_given(slot, brought, left.z + 2u, left.z);
            }
        }
        is = PATH_IS_DIFFUSE;
        path_set_words(field + 1u, slot, vec4u(left.xyz, 0u));
    } else if (kind == LEFT_CASTER && is != PATH_IS_FREE) {
        is = PATH_IS_CAUSTIC;
        if (!goes_on) {
            // No one comes back to what the light sample brings.
            let light = path_words(PATH_LIGHT, slot);
            let less = with_less(vec3f(0.0), bitcast<vec3f>(light.xyz), slot);
            path_set_words(PATH_LIGHT, slot, vec4u(bitcast<vec3u>(less), light.w));
            is = PATH_IS_FREE;
            photons.y = select(0u, SHARES_REST, is_of_first_surface(slot));
        }
    } else if (kind == LEFT_OTHER) {
        is = PATH_IS_FREE;
    }
    if (splits_light) {
        if (is == PATH_IS_CAUSTIC) {
            photons = path_words(field + 1u, slot).xy;
            photons.y = (photons.y & ~SHARES_ABOVE) | select(0u, SHARES_REST, is_of_first_surface(slot));
        }
        let former = path_words(path_given_shares(), slot);
        path_set_words(path_given_shares(), slot, vec4u(former.xy, photons));
    }
    path_write(PATH_RADIANCE, slot, vec4f(radiance, gathered.w));
    path_write(PATH_DIFFUSE, slot, vec4f(brought, 0.0)); // for a cache that learns from it
    path_set_words(field, slot, vec4u(bitcast<vec3u>(radiance), is));
}

// What was gathered before, and of what has come since as much as isn't the photons'.
fn with_less(before: vec3f, after: vec3f, slot: u32) -> vec3f {
    let share = shares_diffuse(path_words(photon_settings.field + 1u, slot).xy);
    return before + (after - before) * (vec3f(1.0) - share);
}

// Whether the surface that the caustic lies on is the first one.
fn is_of_first_surface(slot: u32) -> bool {
    return path_words(photon_settings.field + 1u, slot).z == 0u;
}

// Leaves of what the path's own ray has found as much as isn't the photons'.
fn take_photons_part(slot: u32, number: u32) {
    let found = path_words(split_field(number), slot);
    let less = with_less(vec3f(0.0), bitcast<vec3f>(found.xyz), slot);
    let word = found.w | select(0u, FOUND_REST, is_of_first_surface(slot));
    path_set_words(split_field(number), slot, vec4u(bitcast<vec3u>(less), word));
}

// Notes what is brought to a vertex that scatters diffusely, besides what records may have given for it; `depth` is the vertex's.
fn note_given(slot: u32, light: vec3f, scatterings: u32, depth: u32) {
    let given = bitcast<vec3f>(path_words(path_given(), slot).xyz) + light;
    let word = found_word(scatterings, true, NO_GROUP) | select(0u, FOUND_GIVEN, depth == 0u);
    path_set_words(path_given(), slot, vec4u(bitcast<vec3u>(given), word));
}
