/// A colour divided by its opacity.
/// @param in what goes in = (0, 0, 0, 1)
fn userProc(in: vec4f) -> vec4f {
    return vec4f(select(in.rgb / select(in.a, 1.0, in.a == 0.0), in.rgb, in.a == 0.0), in.a);
}
