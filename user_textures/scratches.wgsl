/// Scratches: 0 is untouched, 1 is the middle of a scratch. Layers of long, thin random cells lie over each other in
/// different directions; noise bends their borders, and some of the borders are scratches. Good as a mask between
/// materials, or to raise the roughness. Uses the first texture coordinates.
/// @param scale     scratches across one unit of uv [0.1 .. 1000] [soft 2 .. 60] [log] = 14
/// @param amount    share of the cells that are scratched [0 .. 1] [percent] = 0.6
/// @param width     width of a scratch, in cells [0 .. 0.5] = 0.08
/// @param length    length of a scratch over its spacing [1 .. 60] = 14
/// @param waviness  how much noise bends them [0 .. 1] = 0.3
/// @param direction main direction in uv [angle] [-3.1416 .. 3.1416] = 0.5
/// @param spread    how far layers differ in direction [0 .. 1] [percent] = 0.6
fn userProc(
    scale: f32,
    amount: f32,
    width: f32,
    length: f32,
    waviness: f32,
    direction: f32,
    spread: f32,
) -> f32 {
    let uv = readAttr(TexCoord0).xy * scale;
    let pixel = readAttr(Footprint).y * scale;
    var untouched = 1.0;
    for (var layer = 0; layer < 4; layer++) {
        // Layers fan out around the main direction, and each is a little finer than the one before.
        let angle = direction + spread * 3.1416 * (f32(pcg(u32(layer) + 7u) >> 8u) / 16777216.0 - 0.5);
        let along = vec2f(cos(angle), sin(angle));
        let frequency = 1.0 + 0.45 * f32(layer);
        let p = frequency * vec2f(dot(uv, along), dot(uv, vec2f(-along.y, along.x))) + 37.0 * f32(layer);
        let bend = noise(p * 0.21) + 0.35 * noise(p * 0.9 + 5.0);
        let q = vec2f(p.x / max(length, 1.0), p.y + waviness * 1.5 * bend);
        let drawn = scratch(q, width, amount, pixel * frequency);
        // Cells smaller than the pixel fade into their mean, which was measured.
        let mean = 0.094 * saturate(amount) * width;
        let depth = mix(drawn, mean, smoothstep(0.3, 1.0, pixel * frequency));
        untouched *= 1.0 - depth * (1.0 - 0.15 * f32(layer));
    }
    return 1.0 - untouched;
}

// How deep the scratch is at p, in a layer whose cells are one unit wide and, stretched, many units long.
fn scratch(p: vec2f, width: f32, amount: f32, pixel: f32) -> f32 {
    let cell = vec2i(floor(p));
    let f = p - floor(p);
    var nearest = 1e9;
    var second = 1e9;
    var id = 0u;
    var to_nearest = vec2f();
    var to_second = vec2f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let step = vec2i(x, y);
            let at = vec2u(cell + step);
            let h = pcg(at.x + pcg(at.y));
            let d = vec2f(step) + vec2f(vec2u(h, h >> 16u) & vec2u(65535u)) / 65535.0 - f;
            let square = dot(d, d);
            if square < nearest {
                second = nearest;
                to_second = to_nearest;
                nearest = square;
                to_nearest = d;
                id = h;
            } else if square < second {
                second = square;
                to_second = d;
            }
        }
    }
    let h = pcg(id);
    let chosen = f32((h >> 8u) & 0xffffu) / 65535.0 < amount;
    if !chosen {
        return 0.0;
    }
    // The border with the cell above: a line along the cells that thins out towards its ends. Borders that run
    // across would be short and, stretched, very wide.
    let border = sqrt(second) - sqrt(nearest);
    let across = to_second - to_nearest;
    let along = smoothstep(0.5, 0.9, across.y / max(length(across), 1e-6));
    let taper = along * saturate(1.5 - 2.2 * abs(to_nearest.x));
    let half_width = width * (0.3 + 0.7 * f32(h & 0xffu) / 255.0) * taper;
    // A line thinner than the pixel is drawn as wide as the pixel, but paler.
    let drawn = max(half_width, max(pixel, 1e-4));
    let strength = 0.35 + 0.65 * f32((h >> 24u) & 0xffu) / 255.0;
    return strength * (half_width / drawn) * (1.0 - smoothstep(0.0, drawn, border));
}

// Value noise with a smooth fade, about -1 to 1.
fn noise(p: vec2f) -> f32 {
    let cell = floor(p);
    let f = p - cell;
    let i = vec2u(vec2i(cell));
    let u = f * f * (3.0 - 2.0 * f);
    let y0 = pcg(i.y);
    let y1 = pcg(i.y + 1u);
    return mix(mix(unit(i.x + y0), unit(i.x + 1u + y0), u.x), mix(unit(i.x + y1), unit(i.x + 1u + y1), u.x), u.y);
}

fn unit(v: u32) -> f32 {
    return f32(pcg(v) >> 8u) / 8388608.0 - 1.0;
}

// An integer hash (O'Neill's PCG, RXS-M-XS).
fn pcg(v: u32) -> u32 {
    let state = v * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
