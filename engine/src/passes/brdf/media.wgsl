// The bodies that a path travels through, and the surfaces that it passes as if they weren't there.

// Sends the path on behind the surface that it met, as if nothing were there.
fn pass_on(p: Path, passage: Passage, t: f32) {
    // What stops shadow rays leaves all of a lamp behind it to the path's own.
    path_write(PATH_THROUGHPUT, p.slot, vec4f(passage.throughput, select(p.bsdf_pdf, 0.0, passage.is_alone)));
    path_write(PATH_RADIANCE, p.slot, vec4f(p.radiance, p.cone_width));
    rays[own_ray(p.slot)].t_min = t;
    rays[own_ray(p.slot)].t_max = 1e30;
    rays[own_ray(p.slot)].triangle = MISS;
    queue_append(QUEUE_ACTIVE, p.slot);
}

// What a medium has left of the throughput on the way to the surface.
fn attenuated(throughput: vec3f, medium: u32, hit: RayHit) -> vec3f {
    if (!has_transmission) {
        return throughput;
    }
    return throughput * medium_transmittance(medium, hit.t_max - hit.t_min);
}

struct Passage {
    passes: bool, // goes on as if nothing were there
    throughput: vec3f,
    is_alone: bool, // shadow rays don't
}

// A random number for a surface, by numbers of triangle and instance that no device's order changes.
fn passage_coin(v: Vertex) -> f32 {
    let instance = instances[v.instance].source;
    return random_at(v.id, vertex_dimension(v.depth, DIMENSION_OPACITY), triangle_number(v.surface.triangle), instance);
}

// Whether the path passes the surface: by its opacity, because it is inside a body that counts more, or because the surface
// is a thin clear wall.
fn sample_passage(v: Vertex, hit: RayHit, throughput_before: vec3f) -> Passage {
    if (gives(v.slot, v.driven, OUTPUT_OPACITY)) {
        let coin = passage_coin(v);
        if (coin >= scalar_or(v.slot, v.driven, OUTPUT_OPACITY, 1.0)) {
            // Where there is no surface, its back doesn't say either that the path was in its body.
            var medium = 0u;
            if (has_transmission) {
                medium = medium_among(path_words(PATH_MEDIA, v.slot));
            }
            return Passage(true, attenuated(throughput_before, medium, hit), false);
        }
    }
    let throughput = attenuated(throughput_before, v.medium, hit);
    if (v.is_solid && medium_among(v.beyond) == v.medium) {
        path_set_words(PATH_MEDIA, v.slot, v.beyond);
        return Passage(true, throughput, true);
    }
    if (v.is_clear) {
        // What goes straight through meets the lights as if the wall were only a filter, as shadow rays do.
        let cosine = dot(v.surface.geometric_normal, v.surface.wo);
        let passing = clear_transmittance(v.material, v.surface.triangle, v.surface.weights, cosine);
        let chance = max_component(passing);
        if (passage_coin(v) < chance) {
            return Passage(true, throughput * passing / chance, false);
        }
        return Passage(false, throughput / (1.0 - chance), false);
    }
    return Passage(false, throughput, false);
}

// The index of refraction of a medium for the path's hue: 1 + material, 0 for air. `own` is the material at hand, whose
// index a texture program may have changed to `own_ior`.
fn medium_ior(medium: u32, own: u32, own_ior: f32, hue: f32) -> f32 {
    if (medium == 0u) {
        return 1.0;
    }
    let ior = select(materials[medium - 1u].ior, own_ior, medium == own + 1u);
    return dispersed(max(ior, 1.0), materials[medium - 1u].dispersion, hue);
}

fn medium_dispersion(medium: u32) -> f32 {
    if (medium == 0u) {
        return 0.0;
    }
    return materials[medium - 1u].dispersion;
}

// What the border of two media means for a surface.
struct MediumBorder {
    eta: f32, // index below over that above
    f0: f32,
    matched: f32, // 0 between equals, where nothing is reflected; else 1
    throughput: vec3f, // of the path, which may have one hue from here on
}

// `ior` is that of the material at hand.
fn medium_border(v: Vertex, ior: f32, throughput: vec3f) -> MediumBorder {
    let behind = medium_among(v.beyond);
    var border = MediumBorder(1.0, 0.0, 1.0, throughput);
    var state = path_words(PATH_STATE, v.slot);
    var hue = bitcast<f32>(state.w);
    if (hue == 0.0 && max(medium_dispersion(v.medium), medium_dispersion(behind)) > 0.0) {
        // It is kept off zero, which stands for white.
        hue = hue_of(random2(v.id, vertex_dimension(v.depth, DIMENSION_HUE))) + HUE_OFFSET;
        border.throughput *= hue_weight(hue - HUE_OFFSET);
        path_set_words(PATH_STATE, v.slot, vec4u(state.xyz, bitcast<u32>(hue)));
    }
    let pure = select(hue - HUE_OFFSET, 0.5, hue == 0.0);
    let here = medium_ior(v.medium, v.own_material, ior, pure);
    let there = medium_ior(behind, v.own_material, ior, pure);
    let ratio = (there - here) / (there + here);
    border.eta = there / here;
    border.f0 = ratio * ratio;
    if (abs(ratio) < 1e-4) {
        border.eta = 1.0;
        border.matched = 0.0;
    }
    if (ior == 0.0) {
        // KHR_materials_ior: all is reflected.
        border.eta = 1.0;
        border.f0 = 1.0;
        border.matched = 1.0;
    }
    return border;
}
