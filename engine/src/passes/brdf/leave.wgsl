// What caches of light must know of a vertex. The passes of `irradiance` and `photons` read it; without it nothing of the path changes.
//!include shared/left.wgsl
//!include brdf/split.wgsl

// Whether the surface throws caustics. It must not depend on where it is seen from: photons and paths come from different sides.
fn is_caster(v: Vertex, b: Bsdf) -> bool {
    return (materials[v.own_material].flags & MATERIAL_CASTER) != 0u && !v.is_clear
        && (1.0 - b.metallic) * (1.0 - b.transmission) <= CASTER_BODY && max_component(b.sheen_color) <= 0.0
        && mean_alpha(b) <= CASTER_ALPHA;
}

// Width of the microfacets' distribution from which on a reflection is taken to be spread over all directions, as far as light comes from
// other surfaces: a roughness of 0.7.
const ROUGH_ALPHA = 0.5;

// Whether the cache of irradiance stands for the reflection, too. It is weak and broad: followed by rays of its own, one in twenty
// goes on, and one of hundreds of these meets what the sun shines on, which leaves a white dot. Light from lamps and the sky is
// reflected as ever.
fn counts_as_diffuse(b: Bsdf, l: Lobes) -> bool {
    return (frame.caches & CACHE_IRRADIANCE) != 0u && mean_alpha(b) >= ROUGH_ALPHA && l.coat_p <= 0.0
        && (!has_layers || b.iridescence <= 0.0);
}

// Of the rays that body and reflection share, those that the reflection gets at least where records stand for the body: a ray of its own
// only has to find lamps and the sky then, which light samples do nearly as well. With more for the reflection, its rays far from where a
// mirror would send them count for more, and leave white dots where they meet what the sun shines on.
const REFLECTED_LEAST = 0.7;

fn favouring_reflection(b: Bsdf, l: Lobes) -> Lobes {
    let both = l.specular_p + l.diffuse_p;
    var changed = l;
    if (l.specular_p > 0.0 && l.diffuse_p > 0.0 && mean_alpha(b) < ROUGH_ALPHA) {
        changed.specular_p = max(l.specular_p, REFLECTED_LEAST * both);
        changed.diffuse_p = both - changed.specular_p;
    }
    return changed;
}

// Share of light from all sides that the reflection sends towards the viewer.
fn rough_albedo(b: Bsdf, l: Lobes) -> vec3f {
    let dielectric = b.specular * (b.dielectric_f0 * l.table.x + l.table.y);
    let gloss = mix(l.gloss, vec3f(l.through), b.transmission);
    return mix(gloss * dielectric, l.metal_gloss * (b.base_color * l.table.x + l.table.y), b.metallic);
}

// The side of the surface that what is gathered at a place comes to: on the curved one that the vertices' normals suggest the side of
// these, on a flat triangle its own, whichever way they lean, for it stops what goes below it.
fn gathered_above(s: Surface) -> vec3f {
    let normal = vertices[s.triangle.x].w;
    let is_curved = normal != vertices[s.triangle.y].w || normal != vertices[s.triangle.z].w;
    return select(s.geometric_normal, s.shading_normal, is_curved);
}

// Leaves how the vertex scatters: diffusely, if that is the same from wherever the light comes, not below a sheen, nor where it
// goes to the other side as well. Which part of the rays goes on if a cache knows the place; `enough` is that of those that only have to
// find lamps and the sky.
fn leave_scattering(p: Path, v: Vertex, m: MaterialSample, l: Lobes, origins: RayOrigins, enough: f32) -> f32 {
    if (is_caster(v, m.bsdf)) {
        path_set_words(PATH_LEFT, v.slot, vec4u(0u, 0u, v.depth, LEFT_CASTER));
        return 1.0;
    }
    if (!energy_compensation || l.diffuse_p <= 0.0 || l.sheen_p > 0.0 || l.back_p > 0.0 || (has_transmission && v.medium != 0u)) {
        path_set_words(PATH_LEFT, v.slot, vec4u(0u, 0u, v.depth, LEFT_OTHER));
        return 1.0;
    }
    let body = diffuse_above(m.bsdf, l, vec3f(0.0)) * (1.0 - l.cover);
    var scattered = body;
    let has_rough = counts_as_diffuse(m.bsdf, l);
    if (has_rough) {
        scattered += rough_albedo(m.bsdf, l) / PI;
    }
    if (splits_light && v.depth == 0u) {
        let words = shares_words(body / max(scattered, vec3f(1e-37)), true, 0u);
        path_set_words(path_given_shares(), v.slot, vec4u(words, 0u, 0u));
    }
    path_set_words(PATH_PLACE, v.slot, vec4u(bitcast<vec3u>(origins.above), octahedral_encode(gathered_above(v.surface))));
    path_set_words(PATH_DIFFUSE, v.slot, vec4u(bitcast<vec3u>(p.throughput * scattered), octahedral_encode(m.frame.normal)));
    let is_all = l.through_p <= 0.0 && (has_rough || l.specular_p + l.coat_p <= 0.0);
    if ((frame.caches & CACHE_GIVES) == 0u || !is_all || enough >= 1.0) {
        path_set_words(PATH_LEFT, v.slot, vec4u(0u, 0u, v.depth, LEFT_DIFFUSE));
        return 1.0;
    }
    path_set_words(PATH_LEFT, v.slot, vec4u(0u, bitcast<u32>(enough), v.depth, LEFT_DIFFUSE | LEFT_FEW));
    return enough;
}

// Leaves by how much the light sample counts for less if all rays go on.
fn leave_light_share(v: Vertex, share: f32) {
    let left = path_words(PATH_LEFT, v.slot);
    path_set_words(PATH_LEFT, v.slot, vec4u(bitcast<u32>(share), left.yzw));
}

// Leaves what the ray has found on a surface that isn't in the table of lights.
fn leave_unsent(p: Path, v: Vertex, found: vec3f) {
    if (leaves_diffuse && materials[v.own_material].light_radiance <= 0.0 && max_component(found) > 0.0) {
        path_set_words(PATH_UNSENT, p.slot, vec4u(bitcast<vec3u>(found), 0u));
    }
}

// Leaves that the ray has met the sky alone.
fn leave_sky(p: Path, radiance: vec3f) {
    path_set_words(PATH_LEFT, p.slot, vec4u(bitcast<vec3u>(p.throughput * radiance), LEFT_SKY));
}

// Leaves that the path goes on, and how much of the light from that direction the vertex scatters diffusely.
fn leave_share(v: Vertex, b: Bsdf, l: Lobes, wo: vec3f, wi: vec3f, value: vec3f) {
    let left = path_words(PATH_LEFT, v.slot);
    let kind = left.w;
    var share = left.xy;
    if (kind == LEFT_DIFFUSE) {
        let is_all = wi.z > 0.0 && counts_as_diffuse(b, l);
        share = shares_words(select(diffuse_share(b, l, wo, wi, value), vec3f(1.0), is_all), wi.z > 0.0, 0u);
    }
    path_set_words(PATH_LEFT, v.slot, vec4u(share, v.depth, kind | LEFT_ON));
}
