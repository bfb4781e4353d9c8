// Rays of ambient occlusion.
//!include shared/ao_tables.wgsl
//!include shared/hit.wgsl
//!include shared/vectors.wgsl

// What the rays of one AO table at a surface have in common.
struct OcclusionSite {
    position: vec3f,
    coarseness: f32, // of the position, as `Surface` has it
    geometric_normal: vec3f,
    normal: vec3f, // around which the rays lie
    tangent: vec3f,
    bitangent: vec3f,
    table: AoTable,
    only_instance: u32, // whose triangles occlude, or MISS for all
    first: u32, // place of the first ray in the sequence of random numbers
    stream: u32, // that sequence
}

// `purpose` is the dimension of random numbers for the first table.
fn occlusion_site(s: Surface, instance: u32, path: PathId, purpose: u32, index: u32) -> OcclusionSite {
    let table = ao_tables[index];
    let tangent = any_perpendicular(s.shading_normal);
    return OcclusionSite(s.position, s.coarseness, s.geometric_normal, s.shading_normal, tangent, cross(s.shading_normal, tangent), table,
        select(MISS, instance, table.same_object != 0u), path.sample * table.samples,
        hash2(path.key, purpose + index));
}

struct OcclusionRay {
    origin: vec3f,
    direction: vec3f,
    is_free: bool, // under the surface because the shading normal leans: counts as free and isn't traced
}

// Ray `sample` of a site.
fn occlusion_ray(at: OcclusionSite, sample: u32) -> OcclusionRay {
    // Consecutive points of one sequence: well spread within a hit and over the samples of a pixel.
    let u = sobol2(at.first + sample, at.stream);
    let radius = sqrt(u.x);
    let around = radius * unit_circle(u.y);
    let height = sqrt(max(1.0 - u.x, 1e-12));
    var direction = at.tangent * around.x + at.bitangent * around.y + at.normal * height;
    var normal = at.geometric_normal;
    if (at.table.direction == AO_INSIDE || (at.table.direction == AO_BOTH && (sample & 1u) == 1u)) {
        direction = -direction;
        normal = -normal;
    }
    return OcclusionRay(offset_origin(at.position, normal, at.coarseness), direction, dot(direction, normal) <= 0.0);
}

struct Occlusion {
    occluded: u32, // rays that hit something
    free: u32, // rays that were not traced
}

// Traces ray `sample` of a site.
fn occlusion(at: OcclusionSite, sample: u32) -> Occlusion {
    let ray = occlusion_ray(at, sample);
    if (ray.is_free) {
        return Occlusion(0u, 1u);
    }
    let coin = hash2(at.stream, at.first + sample);
    let occluder = trace(ray.origin, ray.direction, 0.0, at.table.distance, true, at.only_instance, coin);
    return Occlusion(select(0u, 1u, occluder.triangle != MISS), 0u);
}
