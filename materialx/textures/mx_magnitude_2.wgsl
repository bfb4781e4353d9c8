/// The length.
/// @param in what goes in
fn userProc(in: vec2f) -> f32 {
    return length(in);
}
