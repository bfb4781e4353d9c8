// What the rays of a path meet. `entry.wgsl` is the pass.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/random.wgsl
//!include shared/vectors.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/hit.wgsl

// The cosine between a ray and a triangle's normal in the world.
fn world_cosine(triangle: vec4u, instance: u32, direction: vec3f) -> f32 {
    let a = vertex_position(triangle.x);
    let world_from_object = instances[instance].world_from_object;
    let normal = cross(
        transform_vector(world_from_object, vertex_position(triangle.y) - a),
        transform_vector(world_from_object, vertex_position(triangle.z) - a));
    return dot(normal, direction) * inverseSqrt(max(dot(normal, normal), 1e-37));
}

// A random number for what a ray of the path passes by its alpha.
fn alpha_coin(slot: u32, is_shadow: bool) -> u32 {
    if (!has_alpha) {
        return 0u;
    }
    let path = path_id(slot);
    let stream = hash2(path.key, vertex_dimension(path_depth(slot), DIMENSION_ALPHA));
    return hash2(stream, 2u * path.sample + select(0u, 1u, is_shadow));
}

// The path's own ray, to its closest hit.
fn find_closest(slot: u32) {
    let ray = own_ray(slot);
    let hit = trace(rays[ray].origin, rays[ray].direction, rays[ray].t_min, rays[ray].t_max, false, MISS,
        alpha_coin(slot, false));
    rays[ray].t_max = hit.t;
    rays[ray].barycentrics = hit.barycentrics;
    rays[ray].triangle = hit.triangle;
    rays[ray].instance = hit.instance;
}

// Its shadow ray, to any hit.
fn find_occluder(slot: u32) {
    let ray = shadow_ray(slot);
    let coin = alpha_coin(slot, true);
    var hit = trace(rays[ray].origin, rays[ray].direction, rays[ray].t_min, rays[ray].t_max, true, MISS, coin);
    if (has_clear) {
        // Clear walls are filters.
        var passing = vec3f(1.0);
        while (hit.triangle != MISS && max_component(passing) > 0.0) {
            let triangle = triangles[hit.triangle];
            let material = triangle.w & TRIANGLE_MATERIAL;
            if ((materials[material].flags & MATERIAL_CLEAR) == 0u) {
                break;
            }
            let cosine = world_cosine(triangle, hit.instance, rays[ray].direction);
            passing *= clear_transmittance(material, triangle, barycentric_weights(hit.barycentrics), cosine);
            hit = trace(rays[ray].origin, rays[ray].direction, hit.t, rays[ray].t_max, true, MISS, coin);
        }
        let light = path_words(PATH_LIGHT, slot);
        path_set_words(PATH_LIGHT, slot, vec4u(bitcast<vec3u>(bitcast<vec3f>(light.xyz) * passing), light.w));
    }
    rays[ray].triangle = hit.triangle;
    // Where there is no such program, the triangle needn't be fetched.
    if (has_program_shadows && hit.triangle != MISS && (triangles[hit.triangle].w & TRIANGLE_PROGRAM_ALPHA) != 0u) {
        // A texture program decides how much passes. Then the ray goes on from here.
        rays[ray].t_min = hit.t;
        rays[ray].barycentrics = hit.barycentrics;
        rays[ray].instance = hit.instance;
    }
}
