/// Sand with ripples that wind has made. The colour of the grains; the fourth component is the height, for `bump`.
/// @group materials
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param ripples ripples per metre [0.1 .. 1000] [log] = 8
/// @param height  strength of the ripples [0 .. 1] [percent] = 0.7
/// @param grain   size of a grain [0.00001 .. 0.1] [log] [unit m] = 0.004
/// @param light   colour of light grains [color] = #e2c79a
/// @param dark    colour of dark grains [color] = #9a7748
fn userProc(position: vec4f, ripples: f32, height: f32, grain: f32, light: vec3f, dark: vec3f) -> vec4f {
    let p = position.xyz * ripples;
    let pixel = position.w * ripples;
    let bend = fbm3D(p * vec3f(0.18, 0.18, 0.3), 3.0, 2.0, 0.5, pixel * 0.2);
    let fork = perlin3D(p * vec3f(0.25, 0.25, 0.6) + 5.0);
    let x = fract(p.x + 0.3 * p.y + 1.6 * bend + 0.5 * fork);
    // The windward side is long, the lee side is short.
    let ridge = mix(0.5, select((1.0 - x) / 0.3, x / 0.7, x < 0.7), octaveSeen(pixel));
    let smooth_ridge = ridge * ridge * (3.0 - 2.0 * ridge);
    let g = position.xyz / max(grain, 1e-7);
    let seen = octaveSeen(position.w / max(grain, 1e-7));
    let tone = mix(0.5, random3to1(vec3u(vec3i(floor(g)))), seen);
    let color = mix(dark, light, saturate(0.25 + 0.35 * tone + 0.4 * height * smooth_ridge + 0.15 * bend));
    return vec4f(color, saturate(height * smooth_ridge * 0.85 + 0.15 * tone));
}
