/// A colour multiplied by its opacity.
/// @param in what goes in = (0, 0, 0, 1)
fn userProc(in: vec4f) -> vec4f {
    return vec4f(in.rgb * in.a, in.a);
}
