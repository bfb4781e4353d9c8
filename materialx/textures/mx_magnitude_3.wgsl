/// The length.
/// @param in what goes in
fn userProc(in: vec3f) -> f32 {
    return length(in);
}
