/// Stripes of two colours.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param color_a  colour of the stripes [color] = #d8d2c4
/// @param color_b  colour between them [color] = #2f4858
/// @param scale    stripes per unit of uv [0.1 .. 1000] [soft 1 .. 64] [log] = 8
/// @param share    how much of the width is the first colour [0 .. 1] [percent] = 0.5
/// @param angle    direction [angle] [-3.1416 .. 3.1416] = 0.7854
/// @param softness 0 is sharp [0 .. 1] [percent] = 0
fn userProc(texcoord: vec4f, color_a: vec3f, color_b: vec3f, scale: f32, share: f32, angle: f32, softness: f32) -> vec3f {
    let x = scale * (texcoord.x * cos(angle) + texcoord.y * sin(angle));
    let cover = pulseWave(x + 0.5 * share, share, max(texcoord.w * scale, 0.5 * softness));
    return mix(color_b, color_a, cover);
}
