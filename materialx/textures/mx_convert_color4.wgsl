/// A colour without opacity as one with it.
/// @param in colour
fn userProc(in: vec3f) -> vec4f {
    return vec4f(in, 1.0);
}
