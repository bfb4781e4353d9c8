// Four rays of one hit, traced together: they begin at one point and are short, so they enter nearly the same nodes, and
// each node and triangle is loaded and decoded once for all of them (Wald, Slusallek, Benthin and Wagner, "Interactive
// Rendering with Coherent Ray Tracing", 2001). It pays where loads are dear, as on a processor whose driver loads for one
// lane of a vector after the other.
//!include shared/traversal.wgsl
//!include shared/occlusion.wgsl

const PACKET = 4u;

// Whether rays are traced in packets at all.
override ao_packets: bool = false;

// Component i of each vector is that of ray i.
struct Packet {
    origin: vec3f,
    direction: array<vec4f, 3>,
    reach: vec4f, // how far they go; negative for those that are done or never began
    occluded: vec4u, // 1: it has hit something
    deferred: vec4u, // 1: it has hit something whose alpha must be looked up
}

// The rays as a level of the hierarchy sees them.
struct LevelRays {
    origin: vec3f,
    direction: array<vec4f, 3>,
    inverse: array<vec4f, 3>,
}

fn safe_components(d: vec4f) -> vec4f {
    let tiny = vec4f(1e-18);
    return select(d, select(-tiny, tiny, d >= vec4f(0.0)), abs(d) < tiny);
}

fn level_rays(origin: vec3f, direction: array<vec4f, 3>) -> LevelRays {
    let x = safe_components(direction[0]);
    let y = safe_components(direction[1]);
    let z = safe_components(direction[2]);
    return LevelRays(origin, array<vec4f, 3>(x, y, z), array<vec4f, 3>(1.0 / x, 1.0 / y, 1.0 / z));
}

fn transform_vectors(rows: array<vec4f, 3>, v: array<vec4f, 3>) -> array<vec4f, 3> {
    return array<vec4f, 3>(
        rows[0].x * v[0] + rows[0].y * v[1] + rows[0].z * v[2],
        rows[1].x * v[0] + rows[1].y * v[1] + rows[1].z * v[2],
        rows[2].x * v[0] + rows[2].y * v[1] + rows[2].z * v[2],
    );
}

// As `intersect_node`: a child's bit is set if any of the rays may enter it. Children are in no order, since any hit ends
// a ray.
fn intersect_node_packet(node: u32, rays: LevelRays, reach: vec4f) -> vec4u {
    let n0 = nodes[node];
    let n1 = nodes[node + 1u];
    let nx = nodes[node + 2u];
    let ny = nodes[node + 3u];
    let nz = nodes[node + 4u];
    let scale = bitcast<vec3f>((vec3u(n0.w, n0.w >> 8u, n0.w >> 16u) & vec3u(0xffu)) << vec3u(23u));
    let corner = bitcast<vec3f>(n0.xyz) - rays.origin;
    var mask = 0u;
    for (var child = 0u; child < 8u; child++) {
        let half = child >> 2u;
        let shift = (child & 3u) * 8u;
        let kind = select(n1.z, n1.w, half == 1u) >> shift;
        let near = vec3f((vec3u(nx[half], ny[half], nz[half]) >> vec3u(shift)) & vec3u(0xffu)) * scale + corner;
        let far = vec3f((vec3u(nx[half + 2u], ny[half + 2u], nz[half + 2u]) >> vec3u(shift)) & vec3u(0xffu)) * scale + corner;
        let x1 = near.x * rays.inverse[0];
        let x2 = far.x * rays.inverse[0];
        let y1 = near.y * rays.inverse[1];
        let y2 = far.y * rays.inverse[1];
        let z1 = near.z * rays.inverse[2];
        let z2 = far.z * rays.inverse[2];
        let enter = max(max(min(x1, x2), min(y1, y2)), max(min(z1, z2), vec4f(0.0)));
        let leave = min(min(max(x1, x2), max(y1, y2)), min(max(z1, z2), reach));
        // Widened as there. An empty child's kind is 0 and gives no bits.
        mask |= select(0u, ((kind >> 5u) & 7u) << (kind & 0x1fu), any(enter <= leave * 1.0000005));
    }
    return vec4u(n1.x, n1.y, mask, n0.w >> 24u);
}

// The rays that hit one side or the other of a triangle, as 1: the test of `trace_surfaces` for four.
fn intersect_triangle_packet(triangle: vec4u, rays: LevelRays, reach: vec4f) -> vec4u {
    let a = vertex_position(triangle.x);
    let edge1 = vertex_position(triangle.y) - a;
    let edge2 = vertex_position(triangle.z) - a;
    let px = rays.direction[1] * edge2.z - rays.direction[2] * edge2.y;
    let py = rays.direction[2] * edge2.x - rays.direction[0] * edge2.z;
    let pz = rays.direction[0] * edge2.y - rays.direction[1] * edge2.x;
    let determinant = edge1.x * px + edge1.y * py + edge1.z * pz;
    let inverse_determinant = 1.0 / determinant;
    let s = rays.origin - a;
    let q = cross(s, edge1);
    let u = (s.x * px + s.y * py + s.z * pz) * inverse_determinant;
    let v = (rays.direction[0] * q.x + rays.direction[1] * q.y + rays.direction[2] * q.z) * inverse_determinant;
    let t = dot(edge2, q) * inverse_determinant;
    let zero = vec4f(0.0);
    let is_met = (u >= zero) & (v >= zero) & (u + v <= vec4f(1.0)) & (t > zero) & (t < reach);
    let is_double_sided = (triangle.w & TRIANGLE_SINGLE_SIDED) == 0u;
    return select(vec4u(0u), vec4u(1u), is_met & ((determinant >= zero) | vec4<bool>(is_double_sided)));
}

// As `trace_surfaces` with `any`; what may be transparent by its alpha is only noted.
fn trace_packet(packet: ptr<function, Packet>, only_instance: u32) {
    let world = level_rays((*packet).origin, (*packet).direction);
    var level = world;
    var reach = (*packet).reach;
    var occluded = vec4u(0u);
    var deferred = vec4u(0u);
    var stack: array<vec2u, STACK_SIZE>;
    var depth = 0u;
    var floor_depth = IN_TOP_LEVEL; // stack depth at which the current bottom level ends
    var group = vec2u(0u, 0x80000000u);
    var is_done = all(reach < vec4f(0.0));

    while (!is_done) {
        var primitives = group;
        if ((group.y & 0xff000000u) != 0u) {
            let bit = firstLeadingBit(group.y);
            let rest = group.y & ~(1u << bit);
            if ((rest & 0xff000000u) != 0u) {
                stack[depth] = vec2u(group.x, rest);
                depth++;
            }
            let before = countOneBits(group.y & ~(0xffffffffu << (bit - 24u)));
            let node = intersect_node_packet((group.x + before) * 5u, level, reach);
            group = vec2u(node.x, (node.z & 0xff000000u) | node.w);
            primitives = vec2u(node.y, node.z & 0x00ffffffu);
        } else {
            group = vec2u(0u);
        }

        // Enter an instance; what is left of this level waits on the stack.
        if (floor_depth == IN_TOP_LEVEL && primitives.y != 0u) {
            let bit = firstLeadingBit(primitives.y);
            let rest = primitives.y & ~(1u << bit);
            if (rest != 0u) {
                stack[depth] = vec2u(primitives.x, rest);
                depth++;
            }
            if ((group.y & 0xff000000u) != 0u) {
                stack[depth] = group;
                depth++;
            }
            group = vec2u(0u);
            let instance = primitives.x + bit;
            primitives.y = 0u;
            if (only_instance == MISS || only_instance == instance) {
                floor_depth = depth;
                let object_from_world = instances[instance].object_from_world;
                level = level_rays(transform_point(object_from_world, (*packet).origin),
                    transform_vectors(object_from_world, (*packet).direction));
                group = vec2u(instances[instance].root, 0x80000000u);
            }
        }

        while (primitives.y != 0u) {
            let bit = firstLeadingBit(primitives.y);
            primitives.y &= ~(1u << bit);
            let triangle = triangles[primitives.x + bit];
            let met = intersect_triangle_packet(triangle, level, reach);
            if (has_alpha && (triangle.w & TRIANGLE_ALPHA) != 0u) {
                deferred |= met;
            } else {
                occluded |= met;
                reach = select(reach, vec4f(-1.0), met == vec4u(1u));
            }
        }

        if ((group.y & 0xff000000u) == 0u) {
            // The bottom level is done: back to the world.
            if (depth == floor_depth) {
                floor_depth = IN_TOP_LEVEL;
                level = world;
            }
            is_done = depth == 0u || all(reach < vec4f(0.0));
            if (!is_done) {
                depth--;
                group = stack[depth];
            }
        }
    }
    (*packet).occluded = occluded;
    (*packet).deferred = deferred & (vec4u(1u) - occluded);
}

// Traces a packet of a site: rays `first`, `first + step` and so on, those below `end`. They leave on one side.
fn occlusion_packet(at: OcclusionSite, first: u32, step: u32, end: u32) -> Occlusion {
    var packet: Packet;
    var free = 0u;
    for (var i = 0u; i < PACKET; i++) {
        let sample = first + i * step;
        let ray = occlusion_ray(at, sample);
        packet.origin = ray.origin;
        for (var axis = 0u; axis < 3u; axis++) {
            packet.direction[axis][i] = ray.direction[axis];
        }
        packet.reach[i] = select(at.table.distance, -1.0, ray.is_free || sample >= end);
        free += select(0u, 1u, ray.is_free && sample < end);
    }
    trace_packet(&packet, at.only_instance);
    if (has_alpha) {
        for (var i = 0u; i < PACKET; i++) {
            if (packet.deferred[i] != 0u) {
                packet.occluded[i] = occlusion(at, first + i * step).occluded;
            }
        }
    }
    return Occlusion(dot(packet.occluded, vec4u(1u)), free);
}

// Traces all rays of a site.
fn occlusion_in_packets(at: OcclusionSite, count: u32) -> Occlusion {
    // The rays of a packet begin at one point, and the two sides of a surface don't.
    let sides = select(1u, 2u, at.table.direction == AO_BOTH);
    var all = Occlusion(0u, 0u);
    for (var side = 0u; side < sides; side++) {
        for (var first = side; first < count; first += PACKET * sides) {
            let traced = occlusion_packet(at, first, sides, count);
            all.occluded += traced.occluded;
            all.free += traced.free;
        }
    }
    return all;
}
