/// The greater one.
/// @param in1 first = (0, 0, 0, 0)
/// @param in2 second = (0, 0, 0, 0)
fn userProc(in1: vec4f, in2: vec4f) -> vec4f {
    return max(in1, in2);
}
