/// A number between two for each object, the same in every render: for the tint of bricks or leaves that share a material.
/// @group random
/// @param low  least value = 0
/// @param high greatest value = 1
/// @param seed other numbers [seed] = 0
fn userProc(low: f32, high: f32, seed: u32) -> f32 {
    let r = readAttr(ObjectRandom);
    return mix(low, high, randomOf(vec4f(r.xyz, f32(seed))).x);
}
