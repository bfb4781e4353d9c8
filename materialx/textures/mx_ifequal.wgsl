/// The first where the compared value is equal, else the second.
/// @param value1 compared = 0
/// @param value2 with this = 0
/// @param in1    first = (0, 0, 0, 0)
/// @param in2    second = (0, 0, 0, 0)
fn userProc(value1: f32, value2: f32, in1: vec4f, in2: vec4f) -> vec4f {
    return select(in2, in1, value1 == value2);
}
