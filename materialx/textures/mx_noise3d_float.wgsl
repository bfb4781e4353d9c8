/// @use mx_jenkins
/// Gradient noise.
/// @param amplitude factor on the noise = 1
/// @param pivot     the mean = 0
/// @param position  where [attr LocalPos]
fn userProc(amplitude: f32, pivot: f32, position: vec4f) -> f32 {
    return amplitude * perlin3(position.xyz) + pivot;
}
