/// Arccosine in radians.
/// @param in what goes in = (0, 0, 0, 0)
fn userProc(in: vec4f) -> vec4f {
    return acos(clamp(in, vec4f(-1.0), vec4f(1.0)));
}
