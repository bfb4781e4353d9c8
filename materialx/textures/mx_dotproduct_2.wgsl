/// The scalar product.
/// @param in1 first
/// @param in2 second
fn userProc(in1: vec2f, in2: vec2f) -> f32 {
    return dot(in1, in2);
}
