/// Ridges: sharp crests with finer ones on them, as mountains or veins.
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale      features per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 3
/// @param octaves    finer details on coarse ones [1 .. 12] = 6
/// @param lacunarity how much finer each octave is [1.5 .. 4] = 2
/// @param gain       how much weaker each octave is [0 .. 1] = 0.5
/// @param offset     how broad crests are [0.5 .. 1.5] = 1
fn userProc(position: vec4f, scale: f32, octaves: f32, lacunarity: f32, gain: f32, offset: f32) -> f32 {
    let shown = clamp(octaves, 1.0, 12.0);
    let crests = ridged3D(position.xyz * scale, shown, lacunarity, gain, offset, position.w * scale);
    // Crests are as high as the square of the offset.
    return saturate(1.2 * crests / max(offset * offset, 1e-3));
}
