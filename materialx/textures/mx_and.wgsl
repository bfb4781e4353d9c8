/// 1 where it is true, else 0.
/// @param in1 first = false
/// @param in2 second = false
fn userProc(in1: bool, in2: bool) -> f32 {
    return select(0.0, 1.0, in1 && in2);
}
