/// @use mx_jenkins
/// Four gradient noises.
/// @param amplitude factor on the noise = (1, 1, 1, 1)
/// @param pivot     the mean = 0
/// @param texcoord  where [attr TexCoord0]
fn userProc(amplitude: vec4f, pivot: f32, texcoord: vec4f) -> vec4f {
    let p = texcoord.xy;
    return amplitude * vec4f(perlinOf3_2(p), perlin2(p + vec2f(19.0, 73.0))) + pivot;
}
