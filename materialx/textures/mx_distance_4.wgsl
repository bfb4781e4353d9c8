/// How far two points are apart.
/// @param in1 first
/// @param in2 second
fn userProc(in1: vec4f, in2: vec4f) -> f32 {
    return length(in1 - in2);
}
