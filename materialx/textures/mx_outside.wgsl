/// What is outside of a mask.
/// @param in   what goes in = (0, 0, 0, 0)
/// @param mask what is taken away = 0
fn userProc(in: vec4f, mask: f32) -> vec4f {
    return in * (1.0 - mask);
}
