/// Scratches: 0 is untouched, 1 is the middle of a scratch. Layers of long, thin random cells lie over each other in
/// different directions; noise bends their borders, and some of the borders are scratches. Good as a mask between
/// materials, or to raise the roughness.
/// @param scale     scratches across one unit of uv [0.1 .. 1000] [soft 2 .. 60] [log] = 14
/// @param amount    share of the cells that are scratched [0 .. 1] [percent] = 0.6
/// @param width     width of a scratch, in cells [0 .. 0.5] = 0.08
/// @param length    length of a scratch over its spacing [1 .. 60] = 14
/// @param waviness  how much noise bends them [0 .. 1] = 0.3
/// @param direction main direction in uv [angle] [-3.1416 .. 3.1416] = 0.5
/// @param spread    how far layers differ in direction [0 .. 1] [percent] = 0.6
/// @group weathering
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
fn userProc(
    scale: f32,
    amount: f32,
    width: f32,
    length: f32,
    waviness: f32,
    direction: f32,
    spread: f32,
    texcoord: vec4f,
) -> f32 {
    let uv = texcoord.xy * scale;
    let pixel = texcoord.w * scale;
    var untouched = 1.0;
    for (var layer = 0; layer < 4; layer++) {
        // Layers fan out around the main direction, and each is a little finer than the one before.
        let angle = direction + spread * 3.1416 * (random1to1(u32(layer) + 7u) - 0.5);
        let along = vec2f(cos(angle), sin(angle));
        let frequency = 1.0 + 0.45 * f32(layer);
        let p = frequency * vec2f(dot(uv, along), dot(uv, vec2f(-along.y, along.x))) + 37.0 * f32(layer);
        let bend = valueNoise2D(p * 0.21) + 0.35 * valueNoise2D(p * 0.9 + 5.0);
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
    let cell = voronoi2D(p, 1.0);
    let h = hashU1(cell.id);
    let chosen = f32((h >> 8u) & 0xffffu) / 65535.0 < amount;
    if !chosen {
        return 0.0;
    }
    // The border with the cell above: a line along the cells that thins out towards its ends. Borders that run
    // across would be short and, stretched, very wide.
    let border = cell.second - cell.nearest;
    let across = cell.toSecond.xy - cell.toNearest.xy;
    let along = smoothstep(0.5, 0.9, across.y / max(length(across), 1e-6));
    let taper = along * saturate(1.5 - 2.2 * abs(cell.toNearest.x));
    let half_width = width * (0.3 + 0.7 * f32(h & 0xffu) / 255.0) * taper;
    // A line thinner than the pixel is drawn as wide as the pixel, but paler.
    let drawn = max(half_width, max(pixel, 1e-4));
    let strength = 0.35 + 0.65 * f32((h >> 24u) & 0xffu) / 255.0;
    return strength * (half_width / drawn) * (1.0 - smoothstep(0.0, drawn, border));
}
