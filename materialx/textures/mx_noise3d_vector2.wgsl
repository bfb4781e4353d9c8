/// @use mx_jenkins
/// Two gradient noises.
/// @param amplitude factor on the noise = (1, 1, 1, 1)
/// @param pivot     the mean = 0
/// @param position  where [attr LocalPos]
fn userProc(amplitude: vec4f, pivot: f32, position: vec4f) -> vec4f {
    let p = position.xyz;
    return amplitude * vec4f(perlinOf3_3(p).xy, 0.0, 0.0) + pivot;
}
