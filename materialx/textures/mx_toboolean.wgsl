/// 1 where it is another number than 0.
/// @param in what goes in = 0
fn userProc(in: f32) -> f32 {
    return select(0.0, 1.0, in != 0.0);
}
