/// @use mx_jenkins
/// Three gradient noises.
/// @param amplitude factor on the noise = (1, 1, 1, 1)
/// @param pivot     the mean = 0
/// @param texcoord  where [attr TexCoord0]
fn userProc(amplitude: vec4f, pivot: f32, texcoord: vec4f) -> vec4f {
    return amplitude * vec4f(perlinOf3_2(texcoord.xy), 0.0) + pivot;
}
