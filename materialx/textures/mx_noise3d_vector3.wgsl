/// @use mx_jenkins
/// Three gradient noises.
/// @param amplitude factor on the noise = (1, 1, 1, 1)
/// @param pivot     the mean = 0
/// @param position  where [attr LocalPos]
fn userProc(amplitude: vec4f, pivot: f32, position: vec4f) -> vec4f {
    return amplitude * vec4f(perlinOf3_3(position.xyz), 0.0) + pivot;
}
