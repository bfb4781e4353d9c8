/// Numbers put together.
/// @param in1 first = 0
/// @param in2 second = 0
/// @param in3 third = 0
/// @param in4 fourth = 0
fn userProc(in1: f32, in2: f32, in3: f32, in4: f32) -> vec4f {
    return vec4f(in1, in2, in3, in4);
}
