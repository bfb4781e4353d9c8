/// Woven cloth with threads that are spun from fibres. The colour; the fourth component is the height, for `bump`.
/// @group materials
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param scale   threads per unit of uv [1 .. 10000] [soft 20 .. 1000] [log] = 40
/// @param warp    colour of the threads along v [color] = #2f4a6d
/// @param weft    colour of the threads along u [color] = #d3cbb8
/// @param twill   whether threads go over two and under two, in diagonals = false
/// @param fuzz    how irregular threads are [0 .. 1] [percent] = 0.5
fn userProc(texcoord: vec4f, scale: f32, warp: vec3f, weft: vec3f, twill: bool, fuzz: f32) -> vec4f {
    let pixel = texcoord.w * scale;
    let bend = vec2f(valueNoise2D(texcoord.xy * scale * 0.35), valueNoise2D(texcoord.xy * scale * 0.35 + 50.0));
    let p = texcoord.xy * scale + 0.15 * fuzz * bend;
    let cell = floor(p);
    let f = p - cell - 0.5;
    let period = select(2.0, 4.0, twill);
    let on_top = modulo(cell.x + cell.y, period) < 0.5 * period;
    let high = yarn(f.x, f.y, on_top);
    let flat = yarn(f.y, f.x, !on_top);
    let is_warp = high > flat;
    let height = max(high, flat);
    // Fibres wind around the thread.
    let along = select(p.x, p.y, is_warp);
    let across = select(f.y, f.x, is_warp);
    let strands = valueNoise2D(vec2f(across * 9.0 + along * 4.0, along * 1.5 + 20.0 * select(cell.y, cell.x, is_warp)));
    let number = random1to1(u32(i32(select(cell.y, cell.x, is_warp))) * 2u + select(0u, 1u, is_warp));
    let tint = 1.0 + fuzz * (0.25 * strands * octaveSeen(pixel * 5.0) + 0.3 * (number - 0.5));
    let color = select(weft, warp, is_warp) * tint * (0.35 + 0.65 * height);
    let seen = octaveSeen(0.7 * pixel);
    return vec4f(mix(0.38 * (warp + weft), color, seen), mix(0.6, saturate(height + 0.08 * fuzz * strands), seen));
}

fn yarn(across: f32, along: f32, on_top: bool) -> f32 {
    let x = across / 0.48;
    let round = sqrt(max(1.0 - x * x, 0.0));
    let bend = cos(3.1415927 * along);
    return round * (0.55 + select(-0.3, 0.3, on_top) * (0.4 + 0.6 * bend));
}
