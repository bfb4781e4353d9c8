// Sample points: Sobol's sequence with Joe and Kuo's direction numbers (`sobol.rs`) and hash-based Owen scrambling, one
// shuffled and scrambled copy per purpose (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020). The camera, the
// light sample and the BSDF sample of the first vertex share one copy of twelve dimensions, in this order: what a pixel
// shows of a soft shadow depends on the first six together. Later vertices have copies of four dimensions, small decisions
// of two; between copies there is no more order than between random numbers. All are hashed per pixel and seed, so neither
// neighbours nor pictures of different seeds have anything in common.
//!include shared/frame.wgsl
//!include shared/hash.wgsl

const SAMPLER_SOBOL = 0u;
const SAMPLER_INDEPENDENT = 1u; // plain random numbers, to compare with

// Purposes. Camera first, then sixteen per vertex.
const DIMENSION_CAMERA = 0u; // four: the pixel's filter, the lens
const DIMENSION_VERTEX = 16u;
const DIMENSION_LIGHT = 0u; // four: xy: point of the light; z: which light
const DIMENSION_BLEND = 1u; // x: which side of a material blend
const DIMENSION_BSDF = 2u; // four: x: which lobe; xy: direction; z: whether glass reflects; w: Russian roulette
const GROUP_CAMERA = 0u;
const GROUP_LIGHT = 1u;
const GROUP_BSDF = 2u;
const DIMENSION_ALPHA = 3u; // what the path's ray and its shadow ray pass by their alpha
const DIMENSION_AO = 4u; // and the following, one for each AO table
const DIMENSION_SHADOW_AO = 8u; // the same for what a shadow ray met
const DIMENSION_OPACITY = 12u; // x: whether the path's ray passes, by opacity or through a clear wall
const DIMENSION_SHADOW_BLEND = 13u; // x: which side of a material blend a shadow ray met
const DIMENSION_HUE = 14u; // of a path that is dispersed
const DIMENSION_BUMP = 15u; // two bits: on which sides of a hit heights are compared

// Owen scrambling of a bit-reversed number (Laine and Karras 2011, constants of N. Vegdahl 2021).
fn owen_reversed(x: u32, seed: u32) -> u32 {
    var v = x;
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16u) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
}

// A number in [0, 1) from its 24 highest bits.
fn unit_number(bits: u32) -> f32 {
    return f32(bits >> 8u) * (1.0 / 16777216.0);
}

// Two plain random numbers for sample `index` of a stream.
fn independent2(index: u32, stream: u32) -> vec2f {
    let seed = hash2(stream, index);
    return vec2f(unit_number(seed), unit_number(hash(seed ^ 0x68bc21ebu)));
}

// Two numbers in [0, 1) for sample `index` of a stream. The second dimension is a subset-sum transform of the index, so it
// needs no table.
fn sobol2(index: u32, stream: u32) -> vec2f {
    if (frame.sampler == SAMPLER_INDEPENDENT) {
        return independent2(index, stream);
    }
    let shuffled = reverseBits(owen_reversed(reverseBits(index), stream));
    var second = shuffled;
    second ^= (second >> 1u) & 0x55555555u;
    second ^= (second >> 2u) & 0x33333333u;
    second ^= (second >> 4u) & 0x0f0f0f0fu;
    second ^= (second >> 8u) & 0x00ff00ffu;
    second ^= (second >> 16u) & 0x0000ffffu;
    let x = reverseBits(owen_reversed(shuffled, hash(stream ^ 0x68bc21ebu)));
    let y = reverseBits(owen_reversed(second, hash(stream ^ 0x02e5be93u)));
    return vec2f(unit_number(x), unit_number(y));
}

// Four numbers in [0, 1) for sample `index` of a stream: the dimensions of a group. Groups of one `order` belong to the same
// points; each stream is scrambled on its own.
fn sobol4(index: u32, order: u32, group: u32, stream: u32) -> vec4f {
    if (frame.sampler == SAMPLER_INDEPENDENT) {
        return vec4f(independent2(index, stream), independent2(index, hash(stream ^ 0x02e5be93u)));
    }
    // Without what shuffling makes of index 0. That is the same word for all indices, and as points are linear in their index, one more
    // constant that scrambles them; but without it small indices stay small, and have few bits to look up.
    var rest = reverseBits(owen_reversed(reverseBits(index), order) ^ owen_reversed(0u, order));
    var point = vec4u(0u);
    for (var row = 128u * group; rest != 0u; row += 16u) {
        point ^= frame.sobol[row + (rest & 15u)];
        rest >>= 4u;
    }
    return vec4f(
        unit_number(reverseBits(owen_reversed(point.x, hash(stream ^ 0x68bc21ebu)))),
        unit_number(reverseBits(owen_reversed(point.y, hash(stream ^ 0x02e5be93u)))),
        unit_number(reverseBits(owen_reversed(point.z, hash(stream ^ 0x967a889bu)))),
        unit_number(reverseBits(owen_reversed(point.w, hash(stream ^ 0x368cc8b7u)))));
}

// Four numbers in [0, 1) for a purpose of a path. `group` is the purpose's place in the points of the first vertex.
fn random4(path: PathId, dimension: u32, group: u32) -> vec4f {
    let in_group = dimension < DIMENSION_VERTEX * 2u;
    let order = select(dimension, DIMENSION_CAMERA, in_group);
    return sobol4(path.sample, hash2(path.key, order), select(0u, group, in_group), hash2(path.key, dimension));
}

// Two numbers in [0, 1) for a purpose of a path.
fn random2(path: PathId, dimension: u32) -> vec2f {
    return sobol2(path.sample, hash2(path.key, dimension));
}

// The dimension for a purpose at the vertex behind `depth` that have scattered.
fn vertex_dimension(depth: u32, purpose: u32) -> u32 {
    return DIMENSION_VERTEX * (depth + 1u) + purpose;
}

// One number in [0, 1) for a purpose of a path and a triangle that one of its rays meets: a ray may meet many. Triangle
// and instance are known by numbers that are the same on every device.
fn random_at(path: PathId, dimension: u32, triangle: u32, instance: u32) -> f32 {
    let stream = hash2(path.key, dimension);
    return sobol2(path.sample, hash2(hash2(stream, triangle), instance)).x;
}

// One of many equal cells, and the place inside it.
struct Cell {
    index: u32,
    place: f32, // in [0, 1)
}

// The cell of `u` among `count`. Of u's 24 bits few are left for the place inside one of many cells: a table of half a
// million leaves five, and an alias table asked with them picks bright cells too seldom. A hash of `salt` refills them.
fn cell_of(u: f32, count: u32, salt: u32) -> Cell {
    let scaled = u * f32(count);
    let index = min(u32(scaled), count - 1u);
    let finer = f32(hash(salt) >> 8u) * (1.0 / 16777216.0) * f32(count) * (1.0 / 16777216.0);
    return Cell(index, clamp(scaled - f32(index) + finer, 0.0, 0.99999994));
}
