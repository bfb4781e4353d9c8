/// The rest of a division, of the sign of the divisor; 0 where that is 0.
/// @param in1 first = (0, 0, 0, 0)
/// @param in2 second = (1, 1, 1, 1)
fn userProc(in1: vec4f, in2: vec4f) -> vec4f {
    let none = in2 == vec4f();
    let divisor = select(in2, vec4f(1.0), none);
    return select(in1 - divisor * floor(in1 / divisor), vec4f(), none);
}
