/// The scalar product.
/// @param in1 first
/// @param in2 second
fn userProc(in1: vec3f, in2: vec3f) -> f32 {
    return dot(in1, in2);
}
