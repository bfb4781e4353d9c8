/// 1 where it is false, else 0.
/// @param in what goes in = false
fn userProc(in: bool) -> f32 {
    return select(1.0, 0.0, in);
}
