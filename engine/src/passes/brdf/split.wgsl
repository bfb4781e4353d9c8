// What the film must know to keep parts of the light apart: where light came from, and how the first surface has scattered
// it. The kernels of `film_layers` read it; nothing of the picture depends on it.
//!include shared/found_light.wgsl

// Notes what the path's own ray has found.
fn note_found(p: Path, field: u32, light: vec3f, is_surface: bool, group: u32) {
    path_set_words(split_field(field), p.slot, vec4u(bitcast<vec3u>(light), found_word(p.depth, is_surface, group)));
}

// The share of diffuse scattering, sheen included, in `value`, which is f |cos| of all lobes.
fn diffuse_share(b: Bsdf, l: Lobes, wo: vec3f, wi: vec3f, value: vec3f) -> vec3f {
    var f = vec3f(0.0);
    if (wi.z > 0.0) {
        if (l.diffuse_p > 0.0) {
            f = diffuse_above(b, l, skin_fresnel(b, dot(wo, normalize(wo + wi))));
        }
        if (has_layers && l.sheen_p > 0.0) {
            f = f * below_sheen(b, l, wi) + sheen_above(b, wo, wi);
        }
        f *= (1.0 - l.cover) * wi.z;
    } else if (l.back_p > 0.0) {
        f = diffuse_below(b, l, wo, wi) * below_layers(b, l);
    }
    return select(vec3f(0.0), f / max(value, vec3f(1e-37)), value > vec3f(0.0));
}

// Notes the lamp of the light sample, and how the first surface scatters its light.
fn note_light_sample(v: Vertex, b: Bsdf, l: Lobes, wo: vec3f, wi: vec3f, value: vec3f, group: u32) {
    var diffuse = vec3f(0.0);
    if (v.depth == 0u) {
        diffuse = diffuse_share(b, l, wo, wi, value);
    }
    let former = path_words(split_field(PATH_SHARES), v.slot);
    path_set_words(split_field(PATH_SHARES), v.slot, vec4u(shares_words(diffuse, wi.z > 0.0, group), former.zw));
}

// Notes how the first surface scatters all light that the path will find.
fn note_path(v: Vertex, b: Bsdf, l: Lobes, wo: vec3f, wi: vec3f, value: vec3f) {
    if (v.depth == 0u) {
        let former = path_words(split_field(PATH_SHARES), v.slot);
        let words = shares_words(diffuse_share(b, l, wo, wi, value), wi.z > 0.0, 0u);
        path_set_words(split_field(PATH_SHARES), v.slot, vec4u(former.xy, words));
    }
}
