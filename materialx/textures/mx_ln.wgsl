/// Natural logarithm.
/// @param in what goes in = (1, 1, 1, 1)
fn userProc(in: vec4f) -> vec4f {
    return log(max(in, vec4f(1.17549435e-38)));
}
