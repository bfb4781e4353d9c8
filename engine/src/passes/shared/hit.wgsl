// What tracing a ray gives, and which triangles let it pass. `traversal.wgsl` traces in the hierarchy of our own,
// `rayquery/queries.wgsl` in the hardware's; both define
//   fn trace(origin, direction, t_min, t_max, any, only_instance) -> Hit
// the closest hit, or with `any` some hit, between t_min and t_max; of one instance unless `only_instance` is MISS.

struct Hit {
    t: f32,
    barycentrics: vec2f,
    triangle: u32,
    instance: u32,
}

// True where the surface lets the ray pass at this point: glTF's alpha mask, or a coin toss with its alpha.
// The coin depends on ray and triangle alone, neither on the order of traversal nor on that of the triangles.
fn is_transparent(triangle: vec4u, barycentrics: vec2f, coin: u32) -> bool {
    let coverage = material_coverage(triangle.w & TRIANGLE_MATERIAL, triangle, barycentric_weights(barycentrics));
    return f32(hash2(coin, triangle_number(triangle)) >> 8u) * (1.0 / 16777216.0) >= coverage;
}

// The ray's part of that coin.
fn alpha_coin(origin: vec3f, direction: vec3f) -> u32 {
    return hash2(hash2(bitcast<u32>(direction.x), bitcast<u32>(direction.y)), bitcast<u32>(origin.x));
}

// Whether any surface of the scene may be transparent.
override has_alpha: bool = true;
