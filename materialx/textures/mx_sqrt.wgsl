/// Square root; 0 of what is negative.
/// @param in what goes in = (0, 0, 0, 0)
fn userProc(in: vec4f) -> vec4f {
    return sqrt(max(in, vec4f()));
}
