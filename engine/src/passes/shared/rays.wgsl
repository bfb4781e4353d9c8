// Rays and what they hit: the seam between traversal and everything else.
// The Rust twin is `wave::RayHit`; a test compares the layouts. Where rays lie, `wave_memory.wgsl` says.

struct RayHit {
    origin: vec3f,
    t_min: f32,
    direction: vec3f, // unit length in the world
    t_max: f32, // distance of the hit once traced
    barycentrics: vec2f, // weights of the triangle's second and third vertex
    triangle: u32, // index into `triangles`, or MISS
    instance: u32, // index into `instances`
}

const MISS = 0xffffffffu;

// The origin of a ray that leaves a surface point towards the side of `normal`, moved by a few ulps so that it
// can't meet its own surface again (Wächter and Binder, Ray Tracing Gems, chapter 6), and by as much as it may lie beside its surface. Near
// the origin it is moved by as much as two metres from it: what is far along the other axes is rounded all the same.
fn offset_origin(p: vec3f, normal: vec3f, coarseness: f32) -> vec3f {
    let n = vec3i(normal * 64.0);
    let moved = bitcast<vec3f>(bitcast<vec3i>(p) + select(n, -n, p < vec3f(0.0)));
    return select(moved, p + normal * (1.0 / 65536.0), abs(p) < vec3f(2.0)) + normal * coarseness;
}

// How far rays go that nothing ends.
const FAR = 1e30;
