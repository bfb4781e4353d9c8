/// Random cells with borders of one width: 1 on the border, 0 in the cell. As nets, cobbles or the skin of a giraffe.
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale      cells per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 6
/// @param randomness how irregular: 0 is a grid of cubes [0 .. 1] = 1
/// @param width      width of the border, in cells [0 .. 0.5] = 0.06
/// @param softness   how soft it ends, in cells [0 .. 0.5] = 0.02
fn userProc(position: vec4f, scale: f32, randomness: f32, width: f32, softness: f32) -> f32 {
    let pixel = position.w * scale;
    let edge = voronoiEdge3D(position.xyz * scale, saturate(randomness));
    let half = 0.5 * width;
    // Thinner than a pixel it is drawn as wide as that, but paler.
    let drawn = max(half, 0.5 * pixel);
    let border = (half / max(drawn, 1e-6)) * (1.0 - softStep(drawn, drawn + softness, edge, pixel));
    // The share of space within a distance of a border.
    let mean = select(0.0, 1.0 - exp(-6.3 * (half + 0.5 * softness)), width > 0.0);
    return mix(mean, border, octaveSeen(0.4 * pixel));
}
