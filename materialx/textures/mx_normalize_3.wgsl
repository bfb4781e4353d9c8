/// The direction, of length 1.
/// @param in what goes in
fn userProc(in: vec3f) -> vec3f {
    let size = max(length(in), 1e-30);
    return in / size;
}
