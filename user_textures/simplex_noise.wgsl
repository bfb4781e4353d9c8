/// Simplex noise: smooth spots without any direction that stands out.
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale     features per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 6
/// @param amplitude half the difference between bright and dark [0 .. 10] = 0.5
/// @param pivot     the mean [-10 .. 10] = 0.5
/// @param seed      another noise [seed] = 0
fn userProc(position: vec4f, scale: f32, amplitude: f32, pivot: f32, seed: u32) -> f32 {
    let p = position.xyz * scale + 100.0 * random1to3(seed);
    return pivot + amplitude * simplex3D(p) * octaveSeen(position.w * scale);
}
