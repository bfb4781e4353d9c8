/// The direction, of length 1.
/// @param in what goes in
fn userProc(in: vec2f) -> vec4f {
    let size = max(length(in), 1e-30);
    return vec4f(in / size, 0.0, 0.0);
}
