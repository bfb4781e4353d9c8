/// The product.
/// @param in1 first = (0, 0, 0, 0)
/// @param in2 second = (1, 1, 1, 1)
fn userProc(in1: vec4f, in2: vec4f) -> vec4f {
    return in1 * in2;
}
