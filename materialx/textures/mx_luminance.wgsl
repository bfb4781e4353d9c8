/// The brightness as a grey.
/// @param in         what goes in = (0, 0, 0, 0)
/// @param lumacoeffs weights of red, green and blue = (0.2722287, 0.6740818, 0.0536895)
fn userProc(in: vec4f, lumacoeffs: vec3f) -> vec4f {
    return vec4f(vec3f(dot(in.rgb, lumacoeffs)), in.a);
}
