/// A random colour for every place, as fine as numbers go: for dithering and for random numbers of what is linked. The first three
/// components are independent.
/// @group noise
/// @param value what the numbers depend on; link anything [attr LocalPos]
/// @param seed  other numbers [seed] = 0
fn userProc(value: vec3f, seed: u32) -> vec3f {
    return randomOf(vec4f(value, f32(seed)));
}
