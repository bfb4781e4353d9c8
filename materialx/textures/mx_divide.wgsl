/// The quotient; 0 where the divisor is 0.
/// @param in1 first = (0, 0, 0, 0)
/// @param in2 second = (1, 1, 1, 1)
fn userProc(in1: vec4f, in2: vec4f) -> vec4f {
    let none = in2 == vec4f();
    return select(in1 / select(in2, vec4f(1.0), none), vec4f(), none);
}
