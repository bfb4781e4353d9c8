// What the cache of irradiance must know of a vertex. The passes of `irradiance` read it; without it nothing of the path changes.
//!include shared/left.wgsl
//!include brdf/split.wgsl

// Leaves how the vertex scatters light diffusely, if that is the same from wherever the light comes: not below a sheen, nor where it
// goes to the other side as well.
fn leave_diffuse(p: Path, v: Vertex, m: MaterialSample, l: Lobes, origins: RayOrigins) {
    if (!energy_compensation || l.diffuse_p <= 0.0 || l.sheen_p > 0.0 || l.back_p > 0.0 || (has_transmission && v.medium != 0u)) {
        return;
    }
    let scattered = diffuse_above(m.bsdf, l, vec3f(0.0)) * (1.0 - l.cover);
    path_set_words(PATH_PLACE, v.slot, vec4u(bitcast<vec3u>(origins.above), octahedral_encode(v.surface.shading_normal)));
    path_set_words(PATH_DIFFUSE, v.slot, vec4u(bitcast<vec3u>(p.throughput * scattered), octahedral_encode(m.frame.normal)));
    path_set_words(PATH_LEFT, v.slot, vec4u(0u, 0u, v.depth, LEFT_ENDED));
}

// Leaves how much of the light from a direction the vertex scatters diffusely.
fn leave_share(v: Vertex, b: Bsdf, l: Lobes, wo: vec3f, wi: vec3f, value: vec3f) {
    if (path_words(PATH_LEFT, v.slot).w == LEFT_ENDED) {
        let words = shares_words(diffuse_share(b, l, wo, wi, value), wi.z > 0.0, 0u);
        path_set_words(PATH_LEFT, v.slot, vec4u(words, v.depth, LEFT_ON));
    }
}
