// Ray against scene by the hardware's ray queries, with the same rules as `shared/traversal.wgsl`. A mesh whose triangles
// all end any ray is built as opaque, and the hardware alone decides; of other meshes each candidate is judged here.
//!include shared/geometry.wgsl
//!include shared/hit.wgsl

@group(0) @binding(40) var scene_structure: acceleration_structure;
@group(0) @binding(41) var<storage, read> first_triangles: array<u32>; // of each instance's mesh in `triangles`

// Whether every triangle of the scene is single-sided, so that the hardware can leave out all backs.
override is_single_sided: bool = false;

// Bits of Vulkan's ray flags.
const RAY_FLAG_NO_OPAQUE = 0x02u; // every triangle is a candidate
const RAY_FLAG_FIRST_HIT = 0x04u;
const RAY_FLAG_NO_BACKS = 0x10u;

// Whether a triangle that the ray meets is there for it.
fn is_hit(candidate: RayIntersection, t_min: f32, coin: u32, only_instance: u32) -> bool {
    if (only_instance != MISS && candidate.instance_index != only_instance) {
        return false;
    }
    let index = first_triangles[candidate.instance_index] + candidate.primitive_index;
    let triangle = triangles[index];
    let culled = (triangle.w & TRIANGLE_SINGLE_SIDED) != 0u && !candidate.front_face;
    if (culled || candidate.t <= t_min) {
        return false;
    }
    return !has_alpha || (triangle.w & TRIANGLE_ALPHA) == 0u
        || !is_transparent(triangle, candidate.instance_index, candidate.barycentrics, coin);
}

fn trace(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32, any: bool, only_instance: u32, coin: u32) -> Hit {
    let nothing = Hit(t_max, vec2f(0.0), MISS, 0u);
    if (!(t_max > t_min)) {
        return nothing; // a dead ray, which must not be handed to the hardware
    }
    var flags = select(0u, RAY_FLAG_NO_BACKS, is_single_sided);
    if (any && !has_program_shadows && !has_clear) {
        // Else surfaces that let some of the ray pass have to be met in their order.
        flags |= RAY_FLAG_FIRST_HIT;
    }
    if (only_instance != MISS) {
        flags |= RAY_FLAG_NO_OPAQUE;
    }
    var query: ray_query;
    rayQueryInitialize(&query, scene_structure, RayDesc(flags, 0xffu, t_min, t_max, origin, direction));
    while (rayQueryProceed(&query)) {
        if (is_hit(rayQueryGetCandidateIntersection(&query), t_min, coin, only_instance)) {
            rayQueryConfirmIntersection(&query);
        }
    }
    let found = rayQueryGetCommittedIntersection(&query);
    if (found.kind == 0u) {
        return nothing;
    }
    let triangle = first_triangles[found.instance_index] + found.primitive_index;
    return Hit(found.t, found.barycentrics, triangle, found.instance_index);
}
