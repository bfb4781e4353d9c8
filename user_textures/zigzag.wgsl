/// Zigzag lines, as chevrons.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param color_a colour of the lines [color] = #e9d8a6
/// @param color_b colour between them [color] = #005f73
/// @param scale   lines per unit of uv [0.1 .. 1000] [soft 1 .. 64] [log] = 8
/// @param height  how far they go up and down, in lines [0 .. 4] = 0.5
/// @param share   how much is the first colour [0 .. 1] [percent] = 0.5
fn userProc(texcoord: vec4f, color_a: vec3f, color_b: vec3f, scale: f32, height: f32, share: f32) -> vec3f {
    let p = texcoord.xy * scale;
    let y = p.y + height * abs(2.0 * fract(0.5 * p.x) - 1.0);
    return mix(color_b, color_a, pulseWave(y, share, texcoord.w * scale * (1.0 + height)));
}
