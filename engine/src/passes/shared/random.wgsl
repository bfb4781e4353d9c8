// Sample points: the Sobol (0,2)-sequence with hash-based Owen scrambling, one shuffled and scrambled copy per purpose
// (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020). Two dimensions, so no direction table is needed:
// the second one is a subset-sum transform of the index.

// Purposes, each a pair of dimensions. Camera first, then sixteen per vertex.
const DIMENSION_PIXEL = 0u;
const DIMENSION_LENS = 1u;
const DIMENSION_VERTEX = 16u;
const DIMENSION_LIGHT_POINT = 0u;
const DIMENSION_LIGHT_CHOICE = 1u; // x: which light; y: which side of a material blend
const DIMENSION_BSDF_DIRECTION = 2u;
const DIMENSION_BSDF_LOBE = 3u; // x: which lobe; y: Russian roulette
const DIMENSION_AO = 4u; // and the following, one for each AO table
const DIMENSION_SHADOW_AO = 8u; // the same for what a shadow ray met
const DIMENSION_OPACITY = 12u; // x: whether the path's ray passes, by opacity or through a clear wall
const DIMENSION_SHADOW_BLEND = 13u; // x: which side of a material blend a shadow ray met
const DIMENSION_HUE = 14u; // of a path that is dispersed

fn hash(x: u32) -> u32 {
    // "lowbias32" by C. Wellons.
    var v = x;
    v = (v ^ (v >> 16u)) * 0x7feb352du;
    v = (v ^ (v >> 15u)) * 0x846ca68bu;
    return v ^ (v >> 16u);
}

fn hash2(x: u32, y: u32) -> u32 {
    return hash(x ^ (hash(y) + 0x9e3779b9u));
}

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

// Two numbers in [0, 1) for sample `index` of a stream.
fn sobol2(index: u32, stream: u32) -> vec2f {
    let shuffled = reverseBits(owen_reversed(reverseBits(index), stream));
    var second = shuffled;
    second ^= (second >> 1u) & 0x55555555u;
    second ^= (second >> 2u) & 0x33333333u;
    second ^= (second >> 4u) & 0x0f0f0f0fu;
    second ^= (second >> 8u) & 0x00ff00ffu;
    second ^= (second >> 16u) & 0x0000ffffu;
    let x = reverseBits(owen_reversed(shuffled, hash(stream ^ 0x68bc21ebu)));
    let y = reverseBits(owen_reversed(second, hash(stream ^ 0x02e5be93u)));
    return vec2f(f32(x >> 8u), f32(y >> 8u)) * (1.0 / 16777216.0);
}

// Two numbers in [0, 1) for a purpose of a path.
fn random2(path: PathId, dimension: u32) -> vec2f {
    return sobol2(path.sample, hash2(path.pixel ^ frame.seed, dimension));
}

// The dimension for a purpose at the vertex behind `depth` that have scattered.
fn vertex_dimension(depth: u32, purpose: u32) -> u32 {
    return DIMENSION_VERTEX * (depth + 1u) + purpose;
}

// One number in [0, 1) for a purpose of a path and a triangle that one of its rays meets: a ray may meet many.
fn random_at(path: PathId, dimension: u32, triangle: u32, instance: u32) -> f32 {
    let stream = hash2(path.pixel ^ frame.seed, dimension);
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
