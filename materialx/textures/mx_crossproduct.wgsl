/// The vector product.
/// @param in1 first
/// @param in2 second
fn userProc(in1: vec3f, in2: vec3f) -> vec3f {
    return cross(in1, in2);
}
