//! Noise as MaterialX defines it: lattices hashed by Bob Jenkins' lookup3 (2006, in the public domain), gradients and their
//! scale as in Open Shading Language.

fn rotated(x: u32, bits: u32) -> u32 {
    return (x << bits) | (x >> (32u - bits));
}

// The last step of lookup3, of three numbers.
fn lookupLast(v: vec3u) -> u32 {
    var a = v.x;
    var b = v.y;
    var c = v.z;
    c = (c ^ b) - rotated(b, 14u);
    a = (a ^ c) - rotated(c, 11u);
    b = (b ^ a) - rotated(a, 25u);
    c = (c ^ b) - rotated(b, 16u);
    a = (a ^ c) - rotated(c, 4u);
    b = (b ^ a) - rotated(a, 14u);
    return (c ^ b) - rotated(b, 24u);
}

// A step of lookup3 before the last.
fn lookupMix(v: vec3u) -> vec3u {
    var a = v.x;
    var b = v.y;
    var c = v.z;
    a = (a - c) ^ rotated(c, 4u);
    c += b;
    b = (b - a) ^ rotated(a, 6u);
    a += c;
    c = (c - b) ^ rotated(b, 8u);
    b += a;
    a = (a - c) ^ rotated(c, 16u);
    c += b;
    b = (b - a) ^ rotated(a, 19u);
    a += c;
    c = (c - b) ^ rotated(b, 4u);
    b += a;
    return vec3u(a, b, c);
}

// What lookup3 begins with for so many numbers.
fn lookupSeed(count: u32) -> u32 {
    return 0xdeadbeefu + 4u * count + 13u;
}

fn lookup2(p: vec2i) -> u32 {
    let seed = lookupSeed(2u);
    return lookupLast(vec3u(bitcast<vec2u>(p) + seed, seed));
}

fn lookup3(p: vec3i) -> u32 {
    return lookupLast(bitcast<vec3u>(p) + lookupSeed(3u));
}

fn lookup4(p: vec3i, last: u32) -> u32 {
    let mixed = lookupMix(bitcast<vec3u>(p) + lookupSeed(4u));
    return lookupLast(mixed + vec3u(last, 0u, 0u));
}

fn share(bits: u32) -> f32 {
    return f32(bits) / 4294967295.0;
}

// A number in [0, 1] of the cell.
fn cell2(p: vec2f) -> f32 {
    return share(lookup2(vec2i(floor(p))));
}

fn cell3(p: vec3f) -> f32 {
    return share(lookup3(vec3i(floor(p))));
}

// Three such numbers.
fn cellOf3_2(cell: vec2i) -> vec3f {
    return vec3f(
        share(lookup3(vec3i(cell, 0))),
        share(lookup3(vec3i(cell, 1))),
        share(lookup3(vec3i(cell, 2))),
    );
}

fn cellOf3_3(cell: vec3i) -> vec3f {
    return vec3f(share(lookup4(cell, 0u)), share(lookup4(cell, 1u)), share(lookup4(cell, 2u)));
}

fn turned(x: f32, is_negative: bool) -> f32 {
    return select(x, -x, is_negative);
}

// (1, 2) or (2, 1) with either sign.
fn slope2(hash: u32, p: vec2f) -> f32 {
    let v = select(p.yx, p, (hash & 4u) == 0u);
    return turned(v.x, (hash & 1u) != 0u) + turned(2.0 * v.y, (hash & 2u) != 0u);
}

// Towards the edges of a cube.
fn slope3(hash: u32, p: vec3f) -> f32 {
    let h = hash & 15u;
    let u = select(p.y, p.x, h < 8u);
    let v = select(select(p.z, p.x, h == 12u || h == 14u), p.y, h < 4u);
    return turned(u, (h & 1u) != 0u) + turned(v, (h & 2u) != 0u);
}

fn slopesOf3_2(hash: u32, p: vec2f) -> vec3f {
    return vec3f(slope2(hash, p), slope2(hash >> 8u, p), slope2(hash >> 16u, p));
}

fn slopesOf3_3(hash: u32, p: vec3f) -> vec3f {
    return vec3f(slope3(hash, p), slope3(hash >> 8u, p), slope3(hash >> 16u, p));
}

fn perlin2(p: vec2f) -> f32 {
    let cell = vec2i(floor(p));
    let f = p - floor(p);
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let low = mix(
        slope2(lookup2(cell), f),
        slope2(lookup2(cell + vec2i(1, 0)), f - vec2f(1.0, 0.0)),
        w.x,
    );
    let high = mix(
        slope2(lookup2(cell + vec2i(0, 1)), f - vec2f(0.0, 1.0)),
        slope2(lookup2(cell + vec2i(1, 1)), f - vec2f(1.0, 1.0)),
        w.x,
    );
    return 0.6616 * mix(low, high, w.y);
}

fn perlinOf3_2(p: vec2f) -> vec3f {
    let cell = vec2i(floor(p));
    let f = p - floor(p);
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let low = mix(
        slopesOf3_2(lookup2(cell), f),
        slopesOf3_2(lookup2(cell + vec2i(1, 0)), f - vec2f(1.0, 0.0)),
        w.x,
    );
    let high = mix(
        slopesOf3_2(lookup2(cell + vec2i(0, 1)), f - vec2f(0.0, 1.0)),
        slopesOf3_2(lookup2(cell + vec2i(1, 1)), f - vec2f(1.0, 1.0)),
        w.x,
    );
    return 0.6616 * mix(low, high, w.y);
}

fn perlin3(p: vec3f) -> f32 {
    let cell = vec3i(floor(p));
    let f = p - floor(p);
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    var layers = vec2f();
    for (var z = 0; z < 2; z++) {
        var rows = vec2f();
        for (var y = 0; y < 2; y++) {
            let corner = vec3i(0, y, z);
            let next = vec3i(1, y, z);
            rows[y] = mix(
                slope3(lookup3(cell + corner), f - vec3f(corner)),
                slope3(lookup3(cell + next), f - vec3f(next)),
                w.x,
            );
        }
        layers[z] = mix(rows.x, rows.y, w.y);
    }
    return 0.982 * mix(layers.x, layers.y, w.z);
}

fn perlinOf3_3(p: vec3f) -> vec3f {
    let cell = vec3i(floor(p));
    let f = p - floor(p);
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    var sum = vec3f();
    for (var z = 0; z < 2; z++) {
        for (var y = 0; y < 2; y++) {
            let corner = vec3i(0, y, z);
            let next = vec3i(1, y, z);
            let row = mix(
                slopesOf3_3(lookup3(cell + corner), f - vec3f(corner)),
                slopesOf3_3(lookup3(cell + next), f - vec3f(next)),
                w.x,
            );
            sum += row * select(1.0 - w.y, w.y, y == 1) * select(1.0 - w.z, w.z, z == 1);
        }
    }
    return 0.982 * sum;
}
