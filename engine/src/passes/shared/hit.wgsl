// What tracing a ray gives, and which triangles let it pass. `traversal.wgsl` traces in the hierarchy of our own,
// `rayquery/queries.wgsl` in the hardware's; both define
//   fn trace(origin, direction, t_min, t_max, any, only_instance, coin) -> Hit
// the closest hit, or with `any` some hit, between t_min and t_max; of one instance unless `only_instance` is MISS. `coin` is a
// random number of the ray's for what it may pass.

struct Hit {
    t: f32,
    barycentrics: vec2f,
    triangle: u32,
    instance: u32,
}

// True where the surface lets the ray pass at this point: glTF's alpha mask, or a coin toss with its alpha.
// The coin depends on ray, triangle and instance alone: not on the order of traversal, nor on that of the triangles, nor on
// the last bits of the ray.
fn is_transparent(triangle: vec4u, instance: u32, barycentrics: vec2f, coin: u32) -> bool {
    let coverage = material_coverage(triangle.w & TRIANGLE_MATERIAL, triangle, barycentric_weights(barycentrics));
    let tossed = hash2(hash2(coin, triangle_number(triangle)), instances[instance].source);
    return f32(tossed >> 8u) * (1.0 / 16777216.0) >= coverage;
}

// Whether any surface of the scene may be transparent.
override has_alpha: bool = true;
