// What kernels in lanes have to get right, for `lanes.rs`: each entry point is run in lanes and without.

struct Item {
    place: vec3f,
    count: u32,
    pair: vec2f,
    kind: u32,
    alone: f32,
}

@group(0) @binding(0) var<storage, read> input: array<vec4u>;
@group(0) @binding(1) var<storage, read_write> output: array<vec4u>;
@group(0) @binding(2) var<storage, read_write> items: array<Item>;
@group(0) @binding(3) var<storage, read_write> counters: array<atomic<u32>, 64>;
@group(0) @binding(4) var<storage, read_write> signed_counters: array<atomic<i32>, 64>;

// Loops that each lane leaves when it likes, by each of their ways out.
@compute @workgroup_size(64)
fn rounds(@builtin(global_invocation_id) id: vec3u) {
    let words = input[id.x];
    var sum = 0u;
    var last = 0u;
    for (var i = 0u; i < words.x % 17u; i++) {
        if ((words.y >> i & 1u) == 1u) {
            continue;
        }
        var inner = 0u;
        loop {
            inner += 1u + i;
            last = inner ^ words.z;
            if (last % 11u == 3u) {
                break;
            }
            if (sum > 5000u) {
                output[id.x] = vec4u(sum, last, inner, 1u);
                return;
            }
            sum += last % 251u;
            continuing {
                break if inner > words.w % 40u;
            }
        }
        sum = sum * 3u + inner;
    }
    output[id.x] = vec4u(sum, last, words.x, 2u);
}

// Conditions that all lanes see alike, and short ways that none of them goes.
@compute @workgroup_size(64)
fn agreed(@builtin(global_invocation_id) id: vec3u) {
    let words = input[id.x];
    let same = input[4].x;
    var taken = 0u;
    var others = 0u;
    for (var i = 0u; i < 32u; i++) {
        let is_set = (same >> i & 1u) == 1u;
        if (is_set || words.x % 3u == i % 3u) {
            taken += 1u << (i % 7u);
        }
        if (is_set && words.y % 2u == 0u) {
            others += i;
        }
        var step = 1u;
        if (is_set) {
            step = 5u;
        }
        others = others * 3u + step;
        var own = words.z;
        if (!is_set) {
            own = i;
        } else if (i > 20u) {
            own += 2u;
        }
        others ^= own;
    }
    output[id.x] = vec4u(taken, others, same, 1u);
}

// Ways that part and meet again; some lanes end early.
@compute @workgroup_size(64)
fn branches(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3u) {
    let at = group.x * 64u + local;
    let words = input[at];
    var result = vec4f();
    if ((words.x & 1u) != 0u) {
        if ((words.x & 2u) != 0u) {
            result.x = 1.5;
            if ((words.x & 4u) != 0u) {
                output[at] = vec4u(7u);
                return;
            }
        } else {
            result.y = f32(words.y % 100u);
        }
        result.z = result.x + result.y;
    } else if ((words.x & 8u) != 0u) {
        result.w = -1.0;
    }
    if (group.x == 1u) {
        result.x += 10.0;
    }
    switch words.z % 6u {
        case 0u, 3u: { result.x *= 2.0; }
        case 1u: {
            if (words.w > 0x80000000u) { break; }
            result.y -= 3.0;
        }
        case 2u: {
            output[at] = bitcast<vec4u>(result);
            return;
        }
        default: { result += vec4f(1.0, 2.0, 3.0, 4.0); }
    }
    let both = (words.x & 1u) != 0u && (words.y & 1u) != 0u || words.w % 3u == 0u;
    output[at] = bitcast<vec4u>(select(result, -result.wzyx, both));
}

// Places that lanes append to and meet at.
@compute @workgroup_size(64)
fn meetings(@builtin(global_invocation_id) id: vec3u) {
    let words = input[id.x];
    var places = vec4u(99u);
    if ((words.x & 3u) != 0u) {
        places.x = atomicAdd(&counters[0], 1u);
        atomicAdd(&counters[1], words.y);
        places.y = atomicAdd(&counters[2u + words.z % 5u], 2u);
    }
    places.z = atomicMax(&counters[8], words.y);
    atomicMin(&counters[9], words.y);
    places.w = atomicXor(&counters[10u + words.w % 3u], words.y);
    atomicOr(&counters[14], words.y & words.z);
    atomicSub(&counters[15], words.y);
    atomicMax(&signed_counters[0], bitcast<i32>(words.x));
    atomicMin(&signed_counters[1u + words.y % 2u], bitcast<i32>(words.x));
    places.x += atomicExchange(&counters[16], words.x);
    let swapped = atomicCompareExchangeWeak(&counters[17], words.x & 1u, words.y & 1u);
    places.y += swapped.old_value + select(0u, 4u, swapped.exchanged);
    atomicStore(&counters[20u + id.x % 8u], words.x);
    places.z += atomicLoad(&counters[20u + id.x % 8u]);
    output[id.x] = places;
}

var<private> kept: array<vec3f, 3>;

// Memory of an invocation's own, tables, and what stands together in memory.
@compute @workgroup_size(64)
fn memory(@builtin(global_invocation_id) id: vec3u) {
    let words = input[id.x];
    var own = array<u32, 6>(3u, 1u, 4u, 1u, 5u, 9u);
    var zeros: array<vec4f, 20>;
    for (var i = 0u; i < 6u; i++) {
        own[i] += i * words.x;
        zeros[i] = vec4f(f32(i));
    }
    own[words.y % 6u] ^= words.z;
    kept[words.z % 3u] = vec3f(f32(own[words.x % 6u]));
    zeros[words.w % 20u].y += 0.5;
    var table = array<u32, 12>(31u, 28u, 31u, 30u, 31u, 30u, 31u, 31u, 30u, 31u, 30u, 31u);
    let item = items[id.x ^ 1u];
    if (words.x % 3u != 0u) {
        items[256u + id.x] = Item(item.place.zyx, table[words.w % 12u], item.pair.yx, own[words.z % 6u], item.alone);
    } else {
        items[256u + id.x].pair.y = item.alone;
        items[256u + id.x].kind = item.count;
    }
    output[id.x] = bitcast<vec4u>(zeros[words.y % 20u] + vec4f(kept[words.y % 3u], f32(item.kind)));
}

// Numbers that aren't the same to every operation.
@compute @workgroup_size(64)
fn numbers(@builtin(global_invocation_id) id: vec3u) {
    let words = input[id.x];
    let x = bitcast<vec4f>(words);
    let i = bitcast<vec4i>(words);
    var floats = min(x.xy, x.zw) + max(x.zw, x.xy);
    floats += vec2f(f32(words.x), f32(i.y)) + clamp(x.xz, x.yw, x.wy);
    var bits = vec4u(u32(x.x), u32(i32(x.y)), u32(x.z), u32(i32(x.w)));
    bits ^= vec4u(words.x / max(words.y, 1u), words.x % (words.z >> 20u | 1u), words.z / 3u, words.w % 7u);
    bits += bitcast<vec4u>(vec4i(i.x / (i.y | 1), i.x % (i.z | 1), i.z / -3, i.w % 1000));
    bits ^= vec4u(words.x << (words.y & 31u), words.y >> (words.z & 31u), u32(i.z >> (words.w & 31u)), ~words.x);
    bits += vec4u(countLeadingZeros(words.x), countTrailingZeros(words.y), countOneBits(words.z), reverseBits(words.w));
    bits += vec4u(u32(words.x < words.y), u32(i.x < i.y), u32(x.x < x.y), u32(x.z != x.w));
    bits += vec4u(u32(words.x >= words.y), u32(i.x <= i.y), u32(x.x >= x.y), u32(x.z == x.w));
    bits += vec4u(min(words.x, words.y), max(words.z, words.w), u32(min(i.x, i.y)), u32(max(i.z, i.w)));
    let small = vec4f(words & vec4u(0xffffu)) / 4096.0;
    var waves = vec4f(sin(small.x), cos(small.y), atan2(small.z, small.w - 8.0), pow(small.x, small.y - 8.0));
    waves += vec4f(round(small.x), trunc(-small.y), ceil(small.z), fract(small.w)) + sqrt(abs(x));
    waves.x += ldexp(small.x, i.y % 8) + frexp(small.z).fract;
    bits.x += u32(frexp(small.w).exp) + pack2x16float(small.xy);
    waves.y += unpack2x16float(words.w & 0x3fff3fffu).y;
    bits ^= bitcast<vec4u>(waves);
    output[id.x] = bits + vec4u(bitcast<vec2u>(floats), 0u, 0u);
}
