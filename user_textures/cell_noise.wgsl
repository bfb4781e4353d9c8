/// A random number for each cube of space, as MaterialX's node of that name.
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale cubes per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 8
/// @param seed  other numbers [seed] = 0
fn userProc(position: vec4f, scale: f32, seed: u32) -> f32 {
    let p = position.xyz * scale;
    let number = random4to1(vec4u(vec3u(vec3i(floor(p))), seed));
    return mix(0.5, number, octaveSeen(0.5 * position.w * scale));
}
