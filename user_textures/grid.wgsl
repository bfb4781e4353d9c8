/// Lines in a grid: 1 on a line, 0 between.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param uvtiling  squares per unit of uv [soft 1 .. 64] = (8, 8)
/// @param thickness width of the lines, in squares [0 .. 1] [percent] = 0.06
/// @param staggered whether every other row is shifted by half a square = false
fn userProc(texcoord: vec4f, uvtiling: vec2f, thickness: f32, staggered: bool) -> f32 {
    var p = texcoord.xy * uvtiling;
    let pixel = texcoord.w * abs(uvtiling);
    p.x += select(0.0, 0.5 * modulo(floor(p.y), 2.0), staggered);
    let across = pulseWave(p.x + 0.5 * thickness, thickness, pixel.x);
    let along = pulseWave(p.y + 0.5 * thickness, thickness, pixel.y);
    return 1.0 - (1.0 - across) * (1.0 - along);
}
