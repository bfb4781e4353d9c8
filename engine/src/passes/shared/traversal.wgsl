// Ray against scene: a two-level compressed wide BVH (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on
// GPUs Through Compressed Wide BVHs", HPG 2017). Top-level primitives are instances, bottom-level ones triangles; one
// stack serves both. A node is five vec4u:
//   origin.xyz, exponents and mask of inner children | first child, first primitive, child meta 0-3, 4-7 |
//   min x 0-3, 4-7, max x 0-3, 4-7 | the same for y | the same for z
//!include shared/hit.wgsl

@group(0) @binding(10) var<storage, read> nodes: array<vec4u>;

const STACK_SIZE = 32u; // as much as two hierarchies of `LEVELS` in `bvh` need
const IN_TOP_LEVEL = 0xffffffffu;

// A direction whose components are never so small that their reciprocal overflows.
fn safe_direction(d: vec3f) -> vec3f {
    let tiny = vec3f(1e-18);
    return select(d, select(-tiny, tiny, d >= vec3f(0.0)), abs(d) < tiny);
}

// Mask of a node's children that the ray may enter: bits 24-31 inner children in the order of the ray's octant,
// bits 0-23 triangles of the leaves.
fn intersect_node(node: u32, origin: vec3f, inverse: vec3f, octant4: u32, t_min: f32, t_max: f32) -> vec4u {
    let n0 = nodes[node];
    let n1 = nodes[node + 1u];
    let nx = nodes[node + 2u];
    let ny = nodes[node + 3u];
    let nz = nodes[node + 4u];
    let exponents = vec3u(n0.w, n0.w >> 8u, n0.w >> 16u) & vec3u(0xffu);
    let scale = bitcast<vec3f>(exponents << vec3u(23u)) * inverse;
    let shift = (bitcast<vec3f>(n0.xyz) - origin) * inverse;
    let near_x = select(nx.xy, nx.zw, inverse.x < 0.0);
    let far_x = select(nx.zw, nx.xy, inverse.x < 0.0);
    let near_y = select(ny.xy, ny.zw, inverse.y < 0.0);
    let far_y = select(ny.zw, ny.xy, inverse.y < 0.0);
    let near_z = select(nz.xy, nz.zw, inverse.z < 0.0);
    let far_z = select(nz.zw, nz.xy, inverse.z < 0.0);
    var mask = 0u;
    for (var half = 0u; half < 2u; half++) {
        let meta4 = select(n1.z, n1.w, half == 1u);
        let inner4 = (meta4 & (meta4 << 1u)) & 0x10101010u;
        let inner_mask4 = (inner4 >> 4u) * 0xffu;
        let index4 = unpack4xU8((meta4 ^ (octant4 & inner_mask4)) & 0x1f1f1f1fu);
        let bits4 = unpack4xU8((meta4 >> 5u) & 0x07070707u);
        let enter = max(
            max(vec4f(unpack4xU8(near_x[half])) * scale.x + shift.x, vec4f(unpack4xU8(near_y[half])) * scale.y + shift.y),
            max(vec4f(unpack4xU8(near_z[half])) * scale.z + shift.z, vec4f(t_min)),
        );
        let leave = min(
            min(vec4f(unpack4xU8(far_x[half])) * scale.x + shift.x, vec4f(unpack4xU8(far_y[half])) * scale.y + shift.y),
            min(vec4f(unpack4xU8(far_z[half])) * scale.z + shift.z, vec4f(t_max)),
        );
        // The slab test is widened by the rounding of its few operations (Ize, JCGT 2(2), 2013).
        let child = select(vec4u(0u), bits4 << index4, enter <= leave * 1.0000005);
        mask |= child.x | child.y | child.z | child.w;
    }
    // First child node, first primitive, hits, mask of inner children.
    return vec4u(n1.x, n1.y, mask, n0.w >> 24u);
}

// The closest hit, or with `any` some hit, between t_min and t_max.
//
// Alpha is looked up after traversal, not in its inner loop: there it would cost registers on a GPU, and on a software
// driver, which runs both sides of a branch, the time of every triangle. A ray that meets a transparent point starts
// again behind it.
fn trace(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32, any: bool, only_instance: u32, coin: u32) -> Hit {
    if (!has_alpha) {
        return trace_surfaces(origin, direction, t_min, t_max, any, only_instance);
    }
    var start = t_min;
    var hit: Hit;
    loop {
        hit = trace_surfaces(origin, direction, start, t_max, any, only_instance);
        if (hit.triangle == MISS) {
            break;
        }
        let triangle = triangles[hit.triangle];
        if ((triangle.w & TRIANGLE_ALPHA) == 0u || !is_transparent(triangle, hit.instance, hit.barycentrics, coin)) {
            break;
        }
        start = hit.t;
    }
    return hit;
}

// Which of up to four rays from one place meet something nearer than `t_max`. Their directions are columns of x, y and z; `asked`
// has a bit for each. Bits 0 to 3 of the result are those that are stopped, bits 4 to 7 those that only meet what may let them
// pass: `trace` tells. Devices that do this in Rust do it for all four at once.
fn trace_bundle(origin: vec3f, x: vec4f, y: vec4f, z: vec4f, t_max: f32, asked: u32, only_instance: u32) -> u32 {
    var met = 0u;
    for (var i = 0u; i < 4u; i++) {
        if ((asked >> i & 1u) != 0u) {
            let hit = trace_surfaces(origin, vec3f(x[i], y[i], z[i]), 0.0, t_max, true, only_instance);
            if (hit.triangle != MISS) {
                let may_pass = (triangles[hit.triangle].w & (TRIANGLE_ALPHA | TRIANGLE_PROGRAM_ALPHA)) != 0u;
                met |= 1u << select(i, i + 4u, may_pass);
            }
        }
    }
    return met;
}

// As `trace`, with every triangle opaque. With `any`, a triangle that may be transparent, by its alpha or by a texture
// program, is reported only if it is the closest, so that a ray can go on behind it.
fn trace_surfaces(world_origin: vec3f, world_direction: vec3f, t_min: f32, t_max: f32, any: bool, only_instance: u32) -> Hit {
    var hit = Hit(t_max, vec2f(0.0), MISS, 0u);
    var origin = world_origin;
    var direction = safe_direction(world_direction);
    var inverse = 1.0 / direction;
    var octant = octant_of(direction);
    var stack: array<vec2u, STACK_SIZE>;
    var depth = 0u;
    var floor_depth = IN_TOP_LEVEL; // stack depth at which the current bottom level ends
    var instance = 0u;
    var group = vec2u(0u, 0x80000000u);

    loop {
        var primitives: vec2u;
        if ((group.y & 0xff000000u) != 0u) {
            let bit = firstLeadingBit(group.y);
            let rest = group.y & ~(1u << bit);
            if ((rest & 0xff000000u) != 0u) {
                stack[depth] = vec2u(group.x, rest);
                depth++;
            }
            let slot = (bit - 24u) ^ (octant & 7u);
            let before = countOneBits(group.y & ~(0xffffffffu << slot));
            let node = intersect_node((group.x + before) * 5u, origin, inverse, octant, t_min, hit.t);
            group = vec2u(node.x, (node.z & 0xff000000u) | node.w);
            primitives = vec2u(node.y, node.z & 0x00ffffffu);
        } else {
            primitives = group;
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
            instance = primitives.x + bit;
            primitives.y = 0u;
            if (only_instance == MISS || only_instance == instance) {
                floor_depth = depth;
                origin = transform_point(instances[instance].object_from_world, world_origin);
                direction = safe_direction(transform_vector(instances[instance].object_from_world, world_direction));
                inverse = 1.0 / direction;
                octant = octant_of(direction);
                group = vec2u(instances[instance].root, 0x80000000u);
            }
        }

        while (primitives.y != 0u) {
            let bit = firstLeadingBit(primitives.y);
            primitives.y &= ~(1u << bit);
            let index = primitives.x + bit;
            let triangle = triangles[index];
            // Möller and Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997.
            let a = vertex_position(triangle.x);
            let edge1 = vertex_position(triangle.y) - a;
            let edge2 = vertex_position(triangle.z) - a;
            let p = cross(direction, edge2);
            // Positive where the ray meets the front. That holds in object space even if the instance mirrors, since
            // the front is mirrored with it (glTF 2.0, section 3.7.4).
            let determinant = dot(edge1, p);
            let inverse_determinant = 1.0 / determinant;
            let s = origin - a;
            let u = dot(s, p) * inverse_determinant;
            let q = cross(s, edge1);
            let v = dot(direction, q) * inverse_determinant;
            let t = dot(edge2, q) * inverse_determinant;
            // Written so that a degenerate triangle (NaN) is never hit.
            let culled = (triangle.w & TRIANGLE_SINGLE_SIDED) != 0u && determinant < 0.0;
            if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > t_min && t < hit.t && !culled) {
                hit = Hit(t, vec2f(u, v), index, instance);
                if (any && (triangle.w & (TRIANGLE_ALPHA | TRIANGLE_PROGRAM_ALPHA)) == 0u) {
                    return hit;
                }
            }
        }

        if ((group.y & 0xff000000u) == 0u) {
            // The bottom level is done: back to the world.
            if (depth == floor_depth) {
                floor_depth = IN_TOP_LEVEL;
                origin = world_origin;
                direction = safe_direction(world_direction);
                inverse = 1.0 / direction;
                octant = octant_of(direction);
            }
            if (depth == 0u) {
                break;
            }
            depth--;
            group = stack[depth];
        }
    }
    return hit;
}

// The ray's octant, inverted and repeated in each byte: the order in which children are visited.
fn octant_of(direction: vec3f) -> u32 {
    let bits = select(vec3u(4u, 2u, 1u), vec3u(0u), direction < vec3f(0.0));
    return (bits.x | bits.y | bits.z) * 0x01010101u;
}
