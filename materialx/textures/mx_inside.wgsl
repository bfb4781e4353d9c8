/// What is inside of a mask.
/// @param in   what goes in = (0, 0, 0, 0)
/// @param mask what is kept = 1
fn userProc(in: vec4f, mask: f32) -> vec4f {
    return in * mask;
}
