/// @use mx_jenkins
/// A random number.
/// @param in   what goes in = 0
/// @param min  least = 0
/// @param max  most = 1
/// @param seed another one = 0
fn userProc(in: f32, min: f32, max: f32, seed: i32) -> f32 {
    return mix(min, max, cell2(vec2f(4096.0 * in, f32(seed))));
}
