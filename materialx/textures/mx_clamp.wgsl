/// Held between two values.
/// @param in   what goes in = (0, 0, 0, 0)
/// @param low  least = (0, 0, 0, 0)
/// @param high most = (1, 1, 1, 1)
fn userProc(in: vec4f, low: vec4f, high: vec4f) -> vec4f {
    return max(min(in, high), low);
}
