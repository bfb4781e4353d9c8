/// The nearest whole number; halves go away from 0.
/// @param in what goes in = (0, 0, 0, 0)
fn userProc(in: vec4f) -> vec4f {
    return sign(in) * floor(abs(in) + 0.5);
}
