/// Fractal noise that changes with time, as clouds, flames or light under water.
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale   features per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 4
/// @param octaves finer details on coarse ones [1 .. 12] = 4
/// @param speed   changes per second [0 .. 20] = 0.5
/// @param time    seconds [attr Time]
fn userProc(position: vec4f, scale: f32, octaves: f32, speed: f32, time: f32) -> f32 {
    let p = vec4f(position.xyz * scale, time * speed);
    let shown = clamp(octaves, 1.0, 12.0);
    return saturate(0.5 + 0.6 * fbm4D(p, shown, 2.0, 0.5, position.w * scale));
}
