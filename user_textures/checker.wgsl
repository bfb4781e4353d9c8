/// A checkerboard over the first texture coordinates, filtered exactly over the pixel: from afar it becomes the
/// mean of its colours.
/// @param color_a colour of the first squares [color] = #d9d9d9
/// @param color_b colour of the other squares [color] = #333333
/// @param scale   squares per unit of uv [0.1 .. 1000] [soft 1 .. 64] [log] = 8
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
fn userProc(color_a: vec3f, color_b: vec3f, scale: f32, texcoord: vec4f) -> vec3f {
    let p = texcoord.xy * scale;
    let pixel = texcoord.w * scale;
    let side = squareWave(p.x, pixel) * squareWave(p.y, pixel);
    return mix(color_b, color_a, 0.5 + 0.5 * side);
}
