/// Planks in a herringbone: x is 1 on a plank and 0 in the gap, y a random number of the plank, z 0 or 1 for its direction.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param scale planks' widths in one unit of uv [0.1 .. 200] [soft 2 .. 60] [log] = 16
/// @param ratio length of a plank over its width [2 .. 12] = 4
/// @param gap   width of the gaps, in planks' widths [0 .. 0.4] = 0.06
fn userProc(texcoord: vec4f, scale: f32, ratio: u32, gap: f32) -> vec3f {
    let p = texcoord.xy * scale;
    let pixel = texcoord.w * scale;
    let n = f32(clamp(ratio, 2u, 12u));
    let cell = floor(p);
    // Along each diagonal the planks step by one: which part of which plank this square is.
    let k = modulo(cell.x - cell.y, 2.0 * n);
    let lies = k < n;
    let place = select(2.0 * n - 1.0 - k, k, lies);
    let f = p - cell;
    let along = select(f.y, f.x, lies) + place;
    let across = select(f.x, f.y, lies);
    let border = min(min(along, n - along), min(across, 1.0 - across));
    let corner = select(vec2f(cell.x, cell.y - place), vec2f(cell.x - place, cell.y), lies);
    let number = random2to1(vec2u(vec2i(corner)));
    let seen = octaveSeen(0.6 * pixel);
    let mask = mix((1.0 - gap) * (1.0 - gap / n), edgeStep(0.5 * gap, border, pixel), seen);
    return vec3f(mask, mix(0.5, number, seen), mix(0.5, select(0.0, 1.0, lies), seen));
}
