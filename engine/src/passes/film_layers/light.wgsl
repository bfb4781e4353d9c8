// Adds up the pieces of light that paths find for the layers that are parts of the light: before each vertex what the path
// has found since the one before, and at the end of a wave what is left. One thread per path.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include shared/shadow_rays.wgsl
//!include shared/found_light.wgsl
//!include shared/vectors.wgsl
//!include film_layers/parts.wgsl
//!include film_layers/samples.wgsl
//!include film_layers/words.wgsl
//!include generated/film_light.wgsl

// `bit` is that of the layer among those that the path has brought light for: the first piece is written, and so nothing need be
// cleared for paths that bring none.
fn layer_add(word: u32, bit: u32, slot: u32, value: vec3f) {
    // A piece of light belongs to few of the layers, and to the others nothing is added.
    if (all(value == vec3f(0.0))) {
        return;
    }
    let lit = lit_layers(slot);
    if ((lit & bit) == 0u) {
        set_lit_layers(slot, lit | bit);
        layer_sample_set(word, slot, value.x);
        layer_sample_set(word + 1u, slot, value.y);
        layer_sample_set(word + 2u, slot, value.z);
        return;
    }
    layer_sample_set(word, slot, layer_sample(word, slot) + value.x);
    layer_sample_set(word + 1u, slot, layer_sample(word + 1u, slot) + value.y);
    layer_sample_set(word + 2u, slot, layer_sample(word + 2u, slot) + value.z);
}

// What the path's own ray has found, or a cache has given, and that it has been taken.
fn take_own(slot: u32, field: u32) {
    let words = path_words(field, slot);
    path_set_words(field, slot, vec4u(0u));
    var found: Found;
    found.light = bitcast<vec3f>(words.xyz);
    if (max_component(abs(found.light)) > 0.0) {
        var shares = path_words(split_field(PATH_SHARES), slot).zw;
        if (leaves_diffuse && (words.w & FOUND_GIVEN) != 0u) {
            shares = path_words(path_given_shares(), slot).xy;
        }
        found.scatterings = words.w & 3u;
        found.is_surface = (words.w & FOUND_SURFACE) != 0u;
        found.group = words.w >> FOUND_GROUP_SHIFT;
        found.diffuse = select(shares_diffuse(shares), vec3f(0.0), (words.w & FOUND_REST) != 0u);
        found.is_above = (shares.y & SHARES_ABOVE) != 0u;
        add_found(slot, found);
    }
}

// All of that.
fn take_all(slot: u32) {
    take_own(slot, split_field(PATH_FOUND));
    take_own(slot, split_field(PATH_FOUND_DISKS));
    if (leaves_diffuse) {
        take_own(slot, path_ended());
        take_own(slot, path_given());
    }
}

// Whether the path's first surface is a shadow catcher.
fn is_caught(slot: u32) -> bool {
    return word_caught() != 0u && layer_sample(0u, slot) != 0.0 && layer_sample(word_caught(), slot) != 0.0;
}

// The shadow on the first surface: what has come of its light sample.
fn take_shadow(slot: u32, light: vec3f) {
    let words = path_read(split_field(PATH_CAUGHT), slot);
    path_set_words(split_field(PATH_CAUGHT), slot, vec4u(0u));
    if (words.w > 0.0 && is_caught(slot)) {
        var found: Found;
        found.shadowless = words.xyz;
        // Without the weight that it has beside scattered rays.
        found.arrived = light * (max_component(words.xyz) / words.w);
        add_found(slot, found);
    }
}

// What the path's shadow ray brings, which so many surfaces will have scattered.
fn take_light_sample(slot: u32, scatterings: u32) {
    var light = waiting_light(slot, scatterings);
    if (rays[shadow_ray(slot)].triangle != MISS) {
        light = vec3f(0.0);
    }
    if (catches_shadows) {
        take_shadow(slot, light);
    }
    if (max_component(light) <= 0.0) {
        return;
    }
    let words = path_words(split_field(PATH_SHARES), slot);
    let shares = select(words.zw, words.xy, scatterings <= 1u);
    var diffuse = shares_diffuse(shares);
    if (leaves_diffuse) {
        let photons = path_words(path_given_shares(), slot).zw;
        light *= vec3f(1.0) - shares_diffuse(photons);
        diffuse = select(diffuse, vec3f(0.0), (photons.y & SHARES_REST) != 0u);
    }
    add_found(slot, Found(light, min(scatterings, SCATTERINGS_MOST), true, words.y >> SHARES_GROUP_SHIFT,
        diffuse, (shares.y & SHARES_ABOVE) != 0u, vec3f(0.0), vec3f(0.0)));
}

@compute @workgroup_size(64)
fn record_light(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let depth = path_depth(slot);
    if (depth == 0u) {
        // Nothing has been found before the first surface, but by the path that was here in the wave before.
        set_lit_layers(slot, 0u);
        path_set_words(split_field(PATH_FOUND), slot, vec4u(0u));
        path_set_words(split_field(PATH_FOUND_DISKS), slot, vec4u(0u));
        if (leaves_diffuse) {
            path_set_words(path_ended(), slot, vec4u(0u));
            path_set_words(path_given(), slot, vec4u(0u));
            path_set_words(path_given_shares(), slot, vec4u(0u));
        }
        if (catches_shadows) {
            path_set_words(split_field(PATH_CAUGHT), slot, vec4u(0u));
        }
        return;
    }
    take_all(slot);
    if (!waits_for_program(slot)) {
        take_light_sample(slot, depth);
    }
}

// As `accumulate` takes it for the picture.
@compute @workgroup_size(64)
fn record_last_light(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                     @builtin(local_invocation_index) local: u32) {
    let slot = thread_index(workgroup, workgroups, local);
    if (slot >= frame.wave_size) {
        return;
    }
    take_all(slot);
    if (!has_program_shadows || path_words(PATH_LIGHT_POINT, slot).x == MISS) {
        take_light_sample(slot, path_depth(slot) + 1u);
    }
}
