/// The exponential function.
/// @param in what goes in = (0, 0, 0, 0)
fn userProc(in: vec4f) -> vec4f {
    return exp(min(in, vec4f(88.0)));
}
