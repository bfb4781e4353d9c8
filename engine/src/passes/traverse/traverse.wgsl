// Traces the rays of a queue: `traverse_closest` the paths' own rays, `traverse_occlusion` their shadow rays.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/queues.wgsl
//!include shared/random.wgsl
//!include shared/vectors.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/traversal.wgsl

// The cosine between a ray and a triangle's normal in the world.
fn world_cosine(triangle: vec4u, instance: u32, direction: vec3f) -> f32 {
    let a = vertex_position(triangle.x);
    let world_from_object = instances[instance].world_from_object;
    let normal = cross(
        transform_vector(world_from_object, vertex_position(triangle.y) - a),
        transform_vector(world_from_object, vertex_position(triangle.z) - a));
    return dot(normal, direction) * inverseSqrt(max(dot(normal, normal), 1e-37));
}

@compute @workgroup_size(64)
fn traverse_closest(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                    @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let hit = trace(rays[slot].origin, rays[slot].direction, rays[slot].t_min, rays[slot].t_max, false, MISS);
    rays[slot].t_max = hit.t;
    rays[slot].barycentrics = hit.barycentrics;
    rays[slot].triangle = hit.triangle;
    rays[slot].instance = hit.instance;
}

@compute @workgroup_size(64)
fn traverse_occlusion(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                      @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_SHADOW)) {
        return;
    }
    let path = queue_read(QUEUE_SHADOW, index);
    let slot = frame.capacity + path;
    var hit = trace(rays[slot].origin, rays[slot].direction, rays[slot].t_min, rays[slot].t_max, true, MISS);
    if (has_clear) {
        // Clear walls are filters.
        var passing = vec3f(1.0);
        while (hit.triangle != MISS && max_component(passing) > 0.0) {
            let triangle = triangles[hit.triangle];
            let material = triangle.w & TRIANGLE_MATERIAL;
            if ((materials[material].flags & MATERIAL_CLEAR) == 0u) {
                break;
            }
            let cosine = world_cosine(triangle, hit.instance, rays[slot].direction);
            passing *= clear_transmittance(material, triangle, barycentric_weights(hit.barycentrics), cosine);
            hit = trace(rays[slot].origin, rays[slot].direction, hit.t, rays[slot].t_max, true, MISS);
        }
        let light = path_words(PATH_LIGHT, path);
        path_set_words(PATH_LIGHT, path, vec4u(bitcast<vec3u>(bitcast<vec3f>(light.xyz) * passing), light.w));
    }
    rays[slot].triangle = hit.triangle;
    if (hit.triangle != MISS && (triangles[hit.triangle].w & TRIANGLE_PROGRAM_ALPHA) != 0u) {
        // A texture program decides how much passes. Then the ray goes on from here.
        rays[slot].t_min = hit.t;
        rays[slot].barycentrics = hit.barycentrics;
        rays[slot].instance = hit.instance;
    }
}
