/// A zigzag between 0 and 0.5 with period 1.
/// @param in what goes in = (0, 0, 0, 0)
fn userProc(in: vec4f) -> vec4f {
    return 0.5 - abs(fract(abs(in)) - 0.5);
}
