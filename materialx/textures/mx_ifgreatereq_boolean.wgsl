/// Whether it is so: 1 or 0.
/// @param value1 compared = 1
/// @param value2 with this = 0
/// @param in1    what it is where it is so = 1
/// @param in2    what it is where not = 0
fn userProc(value1: f32, value2: f32, in1: f32, in2: f32) -> f32 {
    return select(in2, in1, value1 >= value2);
}
