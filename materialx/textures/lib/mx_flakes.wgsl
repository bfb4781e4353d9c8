//! Flakes in a lattice, as MaterialX defines them: each cell may have one, a cube that is turned at random.
//! @use mx_jenkins

struct Flake {
    id: f32,       // a whole number, 0 where no flake is
    rand: f32,
    presence: f32, // which of several flakes lies on top
    tilt: vec2f,   // two random numbers for its normal
}

// Two more numbers of a cell, hashed with a fifth one.
fn cellOf3_4(cell: vec3i, last: u32) -> vec3f {
    let mixed = lookupMix(bitcast<vec3u>(cell) + lookupSeed(5u));
    return vec3f(
        share(lookupLast(mixed + vec3u(last, 0u, 0u))),
        share(lookupLast(mixed + vec3u(last, 1u, 0u))),
        share(lookupLast(mixed + vec3u(last, 2u, 0u))),
    );
}

// A random turn (Arvo, Graphics Gems III).
fn turnedFlake(p: vec3f, random: vec3f) -> vec3f {
    let turn = 6.2831853 * random.xy;
    let z = 2.0 * random.z;
    let v = vec3f(sin(turn.y) * sqrt(z), cos(turn.y) * sqrt(z), sqrt(2.0 - z));
    let axis = vec3f(rotate2D(v.xy, turn.x), v.z);
    return axis * dot(v, p) - vec3f(rotate2D(p.xy, turn.x), p.z);
}

// The share of cells that have a flake so that flakes cover a share of the surface: MaterialX's fit.
fn flakeProbability(coverage: f32) -> f32 {
    let x = saturate(coverage);
    let above = (-26.19771808 * x + 26.39663835) * x;
    let below = ((85.53857017 * x - 102.35069432) * x - 101.42634862) * x + 118.45082288;
    return above / below;
}

fn flakeAt(p: vec3f, coverage: f32) -> Flake {
    const HALF = 0.8660254;
    let probability = flakeProbability(coverage);
    let base = vec3i(floor(p));
    var top = 0.0;
    var found = vec3i();
    for (var i = 0; i < 27; i++) {
        let cell = base + vec3i(i / 9, (i / 3) % 3, i % 3) - 1;
        let way = p - vec3f(cell) - 0.5;
        if dot(way, way) >= 3.0 * HALF * HALF || share(lookup3(cell)) > probability {
            continue;
        }
        let priority = share(lookup4(cell, 3u));
        let inside = abs(turnedFlake(way, cellOf3_3(cell)));
        if priority >= top && max(inside.x, max(inside.y, inside.z)) <= HALF {
            top = priority;
            found = cell;
        }
    }
    if top <= 0.0 {
        return Flake(0.0, 0.0, 0.0, vec2f());
    }
    let random = cellOf3_4(found, 2u);
    return Flake(floor(random.z * 16777215.0), random.z, top, random.xy);
}

// Id, random number and presence.
fn flakeFacts(p: vec3f, size: f32, coverage: f32) -> vec3f {
    let flake = flakeAt(p / size, coverage);
    return vec3f(flake.id, flake.rand, flake.presence);
}

// Its normal, by the widths of GGX; the surface's own where no flake is.
fn flakeNormal(p: vec3f, size: f32, coverage: f32, roughness: f32, n: vec3f, t: vec3f, b: vec3f) -> vec3f {
    let flake = flakeAt(p / size, coverage);
    if flake.presence <= 0.0 {
        return n;
    }
    let slope = roughness * roughness * sqrt(flake.tilt.y / max(1.0 - flake.tilt.y, 1e-7));
    let across = slope / sqrt(1.0 + slope * slope);
    let turn = 6.2831853 * flake.tilt.x;
    let sum = across * (t * cos(turn) + b * sin(turn)) + n * sqrt(max(1.0 - across * across, 0.0));
    return sum / max(length(sum), 1e-30);
}
