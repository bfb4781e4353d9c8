/// Gabor noise: waves of one width that run along a direction or, with more spread, anywhere; as combed sand or fingerprints.
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale     patches of waves per metre [0.01 .. 1000] [soft 0.5 .. 20] [log] = 4
/// @param frequency waves in a patch [0.1 .. 10] = 2
/// @param axis      across the waves = (1, 0.3, 0.2)
/// @param spread    how far directions differ [0 .. 1] [percent] = 0.15
/// @param amplitude half the difference between bright and dark [0 .. 10] = 0.5
/// @param pivot     the mean [-10 .. 10] = 0.5
fn userProc(
    position: vec4f,
    scale: f32,
    frequency: f32,
    axis: vec3f,
    spread: f32,
    amplitude: f32,
    pivot: f32,
) -> f32 {
    let along = axis / max(length(axis), 1e-6);
    let seen = octaveSeen(position.w * scale * max(frequency, 1.0));
    return pivot + amplitude * seen * clamp(gabor3D(position.xyz * scale, frequency, along, spread), -1.0, 1.0);
}
