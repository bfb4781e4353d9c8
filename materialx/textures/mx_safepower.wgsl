/// A power of the size, with the sign of the base.
/// @param in1 first = (0, 0, 0, 0)
/// @param in2 second = (1, 1, 1, 1)
fn userProc(in1: vec4f, in2: vec4f) -> vec4f {
    let size = pow(max(abs(in1), vec4f(1e-38)), in2);
    return sign(in1) * min(size, vec4f(3e38));
}
