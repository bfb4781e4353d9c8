// What a vertex sends out: a shadow ray to a light, and the path's next ray.
//!include shared/lights.wgsl
//!include shared/estimator.wgsl
//!include brdf/leave.wgsl

// Where rays leave a vertex. Rays that are reflected leave a curved surface; where others go through, all leave the triangle
// itself, so that lights are weighed from one point.
struct RayOrigins {
    is_opaque: bool,
    lift: vec3f, // of the curved surface above the triangle
    is_lifted: bool,
    above: vec3f,
    below: vec3f,
}

fn ray_origins(v: Vertex, b: Bsdf) -> RayOrigins {
    let s = v.surface;
    let is_opaque = !has_transmission || (b.transmission <= 0.0 && b.diffuse_transmission <= 0.0);
    let lift = select(vec3f(0.0), s.lift, is_opaque);
    let is_lifted = dot(lift, lift) > 1e-12 * dot(s.position, s.position);
    let below = offset_origin(s.position, -s.geometric_normal, s.coarseness);
    let above = offset_origin(s.position + lift, s.geometric_normal, s.coarseness);
    return RayOrigins(is_opaque, lift, is_lifted, above, below);
}

// Whether a ray leaves the surface on the side of its shading normal that it was meant for; `side` is its cosine to the
// triangle. Above a curved surface it may dip below the triangle's plane: then it is for tracing to say what it meets.
fn leaves(cosine: f32, side: f32, is_lifted: bool) -> bool {
    if (cosine > 0.0) {
        return side > 0.0 || is_lifted;
    }
    return has_transmission && cosine < 0.0 && side < 0.0;
}

// What light samples know of the vertex.
fn receiver_at(v: Vertex, m: MaterialSample, origins: RayOrigins) -> u32 {
    // Where a ray may dip below the triangle's plane, the shading normal's horizon is what counts.
    let facing = octahedral_encode(select(v.surface.geometric_normal, m.frame.normal, origins.is_lifted));
    return select(RECEIVER_ALL_AROUND, facing, origins.is_opaque);
}

// Next-event estimation: samples a light, and queues a shadow ray to it with what would arrive. Whether there is one. `going_on` is the
// part of the BSDF's rays that will go on.
fn sample_direct_light(
    p: Path, v: Vertex, m: MaterialSample, l: Lobes, wo: vec3f, origins: RayOrigins, receiver: u32, shares: LightShares, going_on: f32,
) -> bool {
    let s = v.surface;
    path_set_words(PATH_LIGHT, v.slot, vec4u(0u, 0u, 0u, receiver));
    let is_unused = v.depth == 0u && (frame.caches & CACHE_LEARNS) != 0u;
    if (light_groups() == 0u || is_unused) {
        return false;
    }
    let numbers = random4(v.id, vertex_dimension(v.depth, DIMENSION_LIGHT), GROUP_LIGHT);
    let light = light_sample(s.position + origins.lift, origins.above, receiver, shares, numbers.z, numbers.xy);
    let wi = to_local(m.frame, light.wi);
    if (!(light.pdf > 0.0) || !leaves(wi.z, dot(light.wi, s.geometric_normal), origins.is_lifted)) {
        return false;
    }
    let value = bsdf_eval(m.bsdf, l, wo, wi);
    var weight = light_sample_weight(light.pdf, going_on * value.w, light.delta);
    let tells_shadow = catches_shadows && v.depth == 0u && light.point.x == MISS;
    if (tells_shadow) {
        // What a shadow catcher tells of the light doesn't depend on who finds it for the picture: `weight` is divided out below.
        weight = max(weight, 1e-6);
    }
    if (leaves_diffuse && going_on < 1.0 && weight > 0.0) {
        leave_light_share(v, light_sample_weight(light.pdf, value.w, light.delta) / weight);
    }
    var contribution = p.throughput * value.xyz * light.radiance * (weight / light.pdf);
    if (has_transmission && light.distance < FAR) {
        let through = medium_among(select(v.media, v.beyond, wi.z < 0.0));
        contribution *= medium_transmittance(through, light.distance);
    }
    if (!(max_component(contribution) > 0.0)) {
        return false;
    }
    let origin = select(origins.below, origins.above, wi.z > 0.0);
    var direction = light.wi;
    var t_max = light.distance;
    if (light.distance < FAR) {
        let to = s.position + origins.lift + light.wi * light.distance - origin;
        t_max = length(to);
        direction = to / t_max;
        t_max *= 0.9999; // stops short of the light's own surface
    }
    rays[shadow_ray(v.slot)] = RayHit(origin, 0.0, direction, t_max, vec2f(0.0), MISS, 0u);
    path_set_words(PATH_LIGHT, v.slot, vec4u(bitcast<vec3u>(contribution), receiver));
    if (has_program_shadows) {
        path_set_words(PATH_LIGHT_POINT, v.slot, light.point);
    }
    if (splits_light) {
        note_light_sample(v, m.bsdf, l, wo, wi, value.xyz, light.group);
    }
    // What a program makes of a lamp isn't known where something is in its way.
    if (tells_shadow) {
        path_write(split_field(PATH_CAUGHT), v.slot, vec4f(contribution / weight, max_component(contribution)));
    }
    queue_append(QUEUE_SHADOW, v.slot);
    return true;
}

// Russian roulette: what the throughput becomes, zero for a path that ends. By the root of the throughput, paths become rare as fast as
// they become dark; in rooms that takes half to three quarters of the work for the same error as to begin at the fourth vertex with the
// throughput itself. Inside a body radiance is denser, and throughput lower, by the square of its index, which is no reason to end:
// `density` is that index.
fn russian_roulette(throughput: vec3f, depth: u32, density: f32, u: f32) -> vec3f {
    if (depth < frame.roulette_start) {
        return throughput;
    }
    let survival = clamp(sqrt(max_component(throughput)) * density, 0.05, 0.95);
    if (u >= survival) {
        return vec3f(0.0);
    }
    return throughput / survival;
}

// Samples the BSDF, and sends the path on. Whether it goes on, or may: where only a part of such rays is to, a cache says which.
fn sample_indirect(
    p: Path, v: Vertex, m: MaterialSample, l: Lobes, wo: vec3f, origins: RayOrigins, going_on: f32,
) -> bool {
    let numbers = random4(v.id, vertex_dimension(v.depth, DIMENSION_BSDF), GROUP_BSDF);
    let sampled = bsdf_sample(m.bsdf, l, wo, numbers.xyz);
    let direction = to_world(m.frame, sampled.wi);
    let side = dot(direction, v.surface.geometric_normal);
    if (sampled.pdf <= 0.0 || !leaves(sampled.wi.z, side, origins.is_lifted)) {
        return false;
    }
    var density = 1.0;
    if (has_transmission) {
        let media = select(v.media, v.beyond, sampled.wi.z < 0.0);
        path_set_words(PATH_MEDIA, v.slot, media);
        let medium = medium_among(media);
        if (medium != 0u) {
            density = materials[medium - 1u].ior;
        }
    }
    let throughput = russian_roulette(p.throughput * sampled.weight, v.depth, density, numbers.w);
    if (max_component(throughput) <= 0.0) {
        return false;
    }
    if (splits_light) {
        note_path(v, m.bsdf, l, wo, sampled.wi, sampled.weight * sampled.pdf);
    }
    if (leaves_diffuse) {
        leave_share(v, m.bsdf, l, wo, sampled.wi, sampled.weight * sampled.pdf);
    }
    path_write(PATH_THROUGHPUT, v.slot, vec4f(throughput, going_on * sampled.pdf));
    path_set_words(PATH_STATE, v.slot, vec4u(0u, 0u, v.depth + 1u, path_words(PATH_STATE, v.slot).w));
    let origin = select(origins.below, origins.above, sampled.wi.z > 0.0);
    rays[own_ray(v.slot)] = RayHit(origin, 0.0, normalize(direction), 1e30, vec2f(0.0), MISS, 0u);
    if (going_on >= 1.0) {
        queue_append(QUEUE_ACTIVE, v.slot);
    }
    return true;
}

// A path that ends here, but whose shadow ray may have to wait for texture programs, goes on with a dead ray.
fn wait_for_shadow_ray(p: Path) {
    path_set_words(PATH_STATE, p.slot, vec4u(0u, 0u, p.depth + 1u, 0u));
    rays[own_ray(p.slot)].t_max = DEAD;
    queue_append(QUEUE_ACTIVE, p.slot);
}
