// The light tree: which of many lights with a place a point samples, by how bright each may be there. The Rust twin of
// a node is `light_tree::GpuLightNode`, which also says where this comes from. Nodes lie behind the lights.

struct LightNode {
    low: vec3f, // corners of a box around the lights
    child: u32, // first of two children; LIGHT_LEAF and the light's number
    high: vec3f,
    parent: u32,
    axis: vec3f, // middle of the directions in which the lights face
    intensity: f32, // greatest in any direction, relative to all lights
    cos_spread: f32, // of the angle around the axis in which they face
    cos_reach: f32, // of the angle beside these directions up to which they shine
    two_sided: u32, // also to the other side
    sin_spread: f32,
}

const LIGHT_LEAF = 0x80000000u;

// At most this much less is expected of a light that is low above the surface, because bent normals may see it higher.
const LEAST_RECEIVER_COSINE = 0.05;

fn light_node(index: u32) -> LightNode {
    let w = lights[frame.light_count + frame.directional_count + index];
    let d = bitcast<vec4f>(w[3]);
    return LightNode(bitcast<vec3f>(w[0].xyz), w[0].w, bitcast<vec3f>(w[1].xyz), w[1].w, bitcast<vec3f>(w[2].xyz),
        bitcast<f32>(w[2].w), d.x, d.y, w[3].z, d.w);
}

// Cosine and sine of the difference of two angles, or of zero where the second is larger.
fn less_angle(a: vec2f, b: vec2f) -> vec2f {
    if (a.x > b.x) {
        return vec2f(1.0, 0.0);
    }
    return vec2f(a.x * b.x + a.y * b.y, a.y * b.x - a.x * b.y);
}

fn with_sine(cosine: f32) -> vec2f {
    return vec2f(cosine, sqrt(max(1.0 - cosine * cosine, 0.0)));
}

// How bright the lights of a node may be at `p`, on the side of `normal`. Zero only if none of them contributes. Apart from that it is continuous
// in `p`: rounding of `p` changes the densities of multiple importance sampling by as little.
fn light_importance(node: LightNode, p: vec3f, normal: vec3f) -> f32 {
    let half_size = 0.5 * (node.high - node.low);
    let to = node.low + half_size - p;
    let distance2 = dot(to, to);
    let radius2 = dot(half_size, half_size);
    let clamped2 = max(max(distance2, radius2), 1e-20);
    var direction = vec3f(0.0, 1.0, 0.0);
    if (distance2 > 0.0) {
        direction = to * inverseSqrt(distance2);
    }
    // The angle that the node's sphere fills, seen from here.
    var extent = vec2f(-1.0, 0.0);
    if (distance2 > radius2) {
        let sine2 = radius2 / distance2;
        extent = vec2f(sqrt(max(1.0 - sine2, 0.0)), sqrt(sine2));
    }

    var leaving = -dot(node.axis, direction);
    if (node.two_sided != 0u) {
        leaving = abs(leaving);
    }
    let outside = less_angle(less_angle(with_sine(clamp(leaving, -1.0, 1.0)), vec2f(node.cos_spread, node.sin_spread)), extent);
    if (outside.x < node.cos_reach) {
        return 0.0;
    }
    var result = node.intensity * outside.x / clamped2;
    if (any(normal != vec3f(0.0))) {
        let height = dot(normal, to);
        // Packed normals are off by less than this.
        if (height + dot(abs(normal), half_size) < -1e-4 * sqrt(clamped2)) {
            return 0.0;
        }
        let arriving = less_angle(with_sine(clamp(dot(normal, direction), -1.0, 1.0)), extent);
        result *= max(arriving.x, LEAST_RECEIVER_COSINE);
    }
    return result;
}

struct LightChoice {
    index: u32,
    probability: f32, // 0: there is none that contributes
}

// One of the lights with a place. `u` has 24 bits, which the way down uses up: a hash of `salt` refills them.
fn choose_light(p: vec3f, normal: vec3f, u: f32, salt: u32) -> LightChoice {
    var node = light_node(0u);
    var choice = LightChoice(0u, 1.0);
    var bits = hash(salt);
    var place = u;
    var grain = 1.0 / 16777216.0; // what `place` is a multiple of
    while ((node.child & LIGHT_LEAF) == 0u) {
        let left = light_node(node.child);
        let right = light_node(node.child + 1u);
        let a = light_importance(left, p, normal);
        let b = light_importance(right, p, normal);
        if (!(a + b > 0.0)) {
            return LightChoice(0u, 0.0);
        }
        bits = hash(bits);
        place = min(place + f32(bits >> 8u) * (1.0 / 16777216.0) * grain, 0.99999994);
        let share = a / (a + b);
        var taken = share;
        if (place < share) {
            node = left;
            place /= taken;
        } else {
            taken = b / (a + b);
            node = right;
            place = (place - share) / taken;
        }
        place = clamp(place, 0.0, 0.99999994);
        grain = min(1.0 / 16777216.0 / taken, 1.0);
        choice.probability *= taken;
    }
    choice.index = node.child & ~LIGHT_LEAF;
    return choice;
}

// Probability with which `choose_light` finds the light of a leaf.
fn light_probability(leaf: u32, p: vec3f, normal: vec3f) -> f32 {
    var probability = 1.0;
    var at = leaf;
    while (at != 0u) {
        let node = light_node(at);
        let own = light_importance(node, p, normal);
        if (!(own > 0.0)) {
            return 0.0;
        }
        probability *= own / (own + light_importance(light_node(at ^ 1u), p, normal));
        at = node.parent;
    }
    return probability;
}
