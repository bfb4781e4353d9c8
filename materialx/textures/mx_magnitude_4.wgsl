/// The length.
/// @param in what goes in
fn userProc(in: vec4f) -> f32 {
    return length(in);
}
