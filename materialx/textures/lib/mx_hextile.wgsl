//! Three overlapping hexagons at each point, each showing another part of an image (Mikkelsen 2022), with MaterialX's numbers.
//! @use mx_picture

struct HexTile {
    at: array<vec4f, 3>,  // where each part is read, with the width of the pixel
    turns: vec3f,         // radians
    nearness: vec3f,
}

// Two numbers in [0, 1) of a corner of the lattice: Hoskins' hash without sine, which MaterialX takes.
fn hexRandom(corner: vec2f) -> vec2f {
    var p = fract((corner + 0.12345).xyx * vec3f(0.1031, 0.1030, 0.0973));
    p += dot(p, p.yzx + 33.33);
    return fract((p.xx + p.yz) * p.zy);
}

fn hexTile(
    texcoord: vec4f,
    tiling: vec2f,
    rotation: f32,
    rotationrange: vec2f,
    scale: f32,
    scalerange: vec2f,
    offset: f32,
    offsetrange: vec2f,
) -> HexTile {
    const SIDE = 3.4641016;
    // The lattice is laid over the image as it is stored, its first row on top.
    let place = vec2f(0.0, 1.0) + vec2f(1.0, -1.0) * texcoord.xy * tiling;
    let p = place * SIDE;
    let skewed = vec2f(p.x - 0.57735027 * p.y, 1.1547005 * p.y);
    let base = floor(skewed);
    let f = skewed - base;
    let upper = f.x + f.y >= 1.0;
    var tile: HexTile;
    tile.nearness = select(vec3f(1.0 - f.x - f.y, f.yx), vec3f(f.x + f.y - 1.0, 1.0 - f.yx), upper);
    let corners = array<vec2f, 3>(
        base + select(vec2f(), vec2f(1.0), upper),
        base + select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), upper),
        base + select(vec2f(1.0, 0.0), vec2f(0.0, 1.0), upper),
    );
    let width = texcoord.w * max(abs(tiling.x), abs(tiling.y));
    for (var i = 0; i < 3; i++) {
        let corner = corners[i];
        let middle = vec2f(corner.x + 0.5 * corner.y, corner.y / 1.1547005) / SIDE;
        let random = hexRandom(corner);
        let turn = radians(mix(rotationrange.x, rotationrange.y, random.x * rotation));
        let size = mix(1.0, mix(scalerange.x, scalerange.y, random.y), scale);
        let shift = mix(offsetrange.xx, offsetrange.yy, random * offset);
        let uv = rotate2D(place - middle, turn) / size + middle + shift;
        tile.at[i] = vec4f(uv.x, 1.0 - uv.y, 0.0, width / max(abs(size), 1e-6));
        tile.turns[i] = turn;
    }
    return tile;
}

// Schlick's gain (Graphics Gems IV).
fn hexGain(x: f32, r: f32) -> f32 {
    let a = (1.0 / clamp(r, 0.001, 0.999) - 2.0) * (1.0 - 2.0 * x);
    return select((a - x) / (a - 1.0), x / (a + 1.0), x < 0.5);
}

fn hexWeights(bright: vec3f, nearness: vec3f, falloff: f32) -> vec3f {
    let squares = nearness * nearness;
    let raw = bright * squares * squares * squares * nearness;
    let w = raw / (raw.x + raw.y + raw.z);
    if falloff == 0.5 {
        return w;
    }
    let bent = vec3f(hexGain(w.x, falloff), hexGain(w.y, falloff), hexGain(w.z, falloff));
    return bent / (bent.x + bent.y + bent.z);
}
