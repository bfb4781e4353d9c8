// One ray of ambient occlusion.
//!include shared/ao_tables.wgsl
//!include shared/hit.wgsl

struct Occlusion {
    traced: u32, // 1: a ray was traced
    occluded: u32, // 1: and it hit something
}

// Ray `sample` of AO table `index` at a surface. `purpose` is the dimension of random numbers for the first table.
fn occlusion(s: Surface, instance: u32, path: PathId, purpose: u32, index: u32, sample: u32) -> Occlusion {
    let table = ao_tables[index];
    let tangent = any_perpendicular(s.shading_normal);
    let bitangent = cross(s.shading_normal, tangent);
    // Consecutive points of one sequence: well spread within a hit and over the samples of a pixel.
    let stream = hash2(path.pixel ^ frame.seed, purpose + index);
    let u = sobol2(path.sample * table.samples + sample, stream);
    let radius = sqrt(u.x);
    let phi = 6.28318530718 * u.y;
    let height = sqrt(max(1.0 - u.x, 1e-12));
    var direction = tangent * (radius * cos(phi)) + bitangent * (radius * sin(phi)) + s.shading_normal * height;
    var normal = s.geometric_normal;
    if (table.direction == AO_INSIDE || (table.direction == AO_BOTH && (sample & 1u) == 1u)) {
        direction = -direction;
        normal = -normal;
    }
    if (dot(direction, normal) <= 0.0) {
        // Under the surface because the shading normal leans: counts as free.
        return Occlusion(0u, 0u);
    }
    let only_instance = select(MISS, instance, table.same_object != 0u);
    let occluder = trace(offset_origin(s.position, normal), direction, 0.0, table.distance, true, only_instance);
    return Occlusion(1u, select(0u, 1u, occluder.triangle != MISS));
}
