
// Standard functions: random numbers by integer arithmetic, equal on every device.

// An integer hash (O'Neill's PCG, RXS-M-XS): all 32 bits of the result depend on all bits of v.
fn hashU1(v: u32) -> u32 {
    let state = v * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// Hashes of two, three and four numbers.
fn hashU2(v: vec2u) -> u32 { return hashU1(v.x + hashU1(v.y)); }
fn hashU3(v: vec3u) -> u32 { return hashU1(v.x + hashU1(v.y + hashU1(v.z))); }
fn hashU4(v: vec4u) -> u32 { return hashU1(v.x + hashU1(v.y + hashU1(v.z + hashU1(v.w)))); }

// A hash as a number in [0, 1), of its upper 24 bits.
fn unitFloat(hash: u32) -> f32 { return f32(hash >> 8u) / 16777216.0; }

// Random numbers in [0, 1): one, two or three of one to four whole numbers.
fn random1to1(v: u32) -> f32 { return unitFloat(hashU1(v)); }
fn random1to2(v: u32) -> vec2f { return random2of(hashU1(v)); }
fn random1to3(v: u32) -> vec3f { return random3of(hashU1(v)); }
fn random2to1(v: vec2u) -> f32 { return unitFloat(hashU2(v)); }
fn random2to2(v: vec2u) -> vec2f { return random2of(hashU2(v)); }
fn random2to3(v: vec2u) -> vec3f { return random3of(hashU2(v)); }
fn random3to1(v: vec3u) -> f32 { return unitFloat(hashU3(v)); }
fn random3to2(v: vec3u) -> vec2f { return random2of(hashU3(v)); }
fn random3to3(v: vec3u) -> vec3f { return random3of(hashU3(v)); }
fn random4to1(v: vec4u) -> f32 { return unitFloat(hashU4(v)); }
fn random4to2(v: vec4u) -> vec2f { return random2of(hashU4(v)); }
fn random4to3(v: vec4u) -> vec3f { return random3of(hashU4(v)); }

// Two and three numbers in [0, 1) that follow from one hash.
fn random2of(hash: u32) -> vec2f {
    return vec2f(unitFloat(hash), unitFloat(hashU1(hash + 1u)));
}
fn random3of(hash: u32) -> vec3f {
    return vec3f(unitFloat(hash), unitFloat(hashU1(hash + 1u)), unitFloat(hashU1(hash + 2u)));
}

// Random numbers of numbers that are not whole, such as those of a cell or a link: by their bits, so that nearly equal ones differ.
fn randomOf(v: vec4f) -> vec3f { return random4to3(bitcast<vec4u>(v + vec4f(0.0))); }
