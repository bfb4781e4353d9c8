/// A floor of planks: x is 1 on a plank and 0 in the gap, y and z are random numbers of the plank, w is the distance along it.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param rows   planks beside each other in one unit of uv [0.1 .. 200] [soft 2 .. 30] [log] = 7
/// @param length length of a plank over its width [1 .. 50] = 8
/// @param gap    width of the gaps, in planks [0 .. 0.3] = 0.025
fn userProc(texcoord: vec4f, rows: f32, length: f32, gap: f32) -> vec4f {
    let p = texcoord.xy * rows;
    let pixel = texcoord.w * rows;
    let row = floor(p.y);
    // Each row begins anywhere.
    let x = p.x / max(length, 0.1) + random1to1(u32(i32(row)));
    let column = floor(x);
    let along = fract(x) * length;
    let border = min(min(along, length - along), min(p.y - row, row + 1.0 - p.y));
    let mask = edgeStep(0.5 * gap, border, pixel);
    let r = random2to2(vec2u(vec2i(vec2f(column, row))));
    let seen = octaveSeen(0.6 * pixel);
    let covered = (1.0 - gap) * saturate(1.0 - gap / max(length, 0.1));
    return mix(vec4f(covered, 0.5, 0.5, 0.5), vec4f(mask, r, fract(x)), seen);
}
