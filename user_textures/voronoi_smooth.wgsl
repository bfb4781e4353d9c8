/// Random cells that run into each other without creases, as cells under a microscope or bubbles.
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale      cells per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 6
/// @param randomness how irregular: 0 is a grid of cubes [0 .. 1] = 1
/// @param smoothness how wide cells run into each other [0 .. 1] [percent] = 0.4
fn userProc(position: vec4f, scale: f32, randomness: f32, smoothness: f32) -> f32 {
    let smooth_width = saturate(smoothness);
    let distance = voronoiSmooth3D(position.xyz * scale, saturate(randomness), smooth_width);
    let mean = 0.515 + 0.165 * smooth_width * smooth_width;
    return saturate(mix(mean, distance, octaveSeen(0.5 * position.w * scale)));
}
