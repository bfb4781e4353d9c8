/// @use mx_jenkins
/// Gradient noise.
/// @param amplitude factor on the noise = 1
/// @param pivot     the mean = 0
/// @param texcoord  where [attr TexCoord0]
fn userProc(amplitude: f32, pivot: f32, texcoord: vec4f) -> f32 {
    return amplitude * perlin2(texcoord.xy) + pivot;
}
