/// Arcs that join into endless curves, each square turned at random: 1 on a curve, 0 beside it.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param scale squares per unit of uv [0.1 .. 1000] [soft 1 .. 64] [log] = 8
/// @param width width of the curves, in squares [0 .. 1] [percent] = 0.2
/// @param seed  other turns [seed] = 0
fn userProc(texcoord: vec4f, scale: f32, width: f32, seed: u32) -> f32 {
    let p = texcoord.xy * scale;
    let pixel = texcoord.w * scale;
    let cell = floor(p);
    var f = p - cell;
    if random3to1(vec3u(vec2u(vec2i(cell)), seed)) < 0.5 {
        f.x = 1.0 - f.x;
    }
    let d = min(abs(length(f) - 0.5), abs(length(f - 1.0) - 0.5));
    let line = 1.0 - edgeStep(0.5 * width, d, pixel);
    return mix(saturate(1.57 * width), line, octaveSeen(0.6 * pixel));
}
