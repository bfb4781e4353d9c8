/// Pushes places about by noise, so that whatever is looked up there bends and frays.
/// @group coordinates
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param amount  how far [0 .. 10] [soft 0 .. 0.5] [unit m] = 0.1
/// @param scale   bends per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 4
/// @param octaves finer bends on coarse ones [1 .. 12] = 3
/// @param seed    another noise [seed] = 0
fn userProc(position: vec4f, amount: f32, scale: f32, octaves: f32, seed: u32) -> vec4f {
    let p = position.xyz * scale + 100.0 * random1to3(seed);
    let pixel = position.w * scale;
    let push = fbmVector3D(p, clamp(octaves, 1.0, 12.0), 2.0, 0.5, pixel);
    // Bends stretch what is looked up, by about their slope.
    return vec4f(position.xyz + amount * push, position.w * (1.0 + amount * scale));
}
