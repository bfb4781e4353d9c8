/// Fractal noise: octaves of gradient noise, each finer and weaker than the one before. The result lies around
/// 0.5, mostly between 0 and 1. Octaves finer than the pixel fade away, so that distant surfaces do not sparkle.
/// @param scale      features per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 4
/// @param octaves    octaves; a fraction is a weaker last octave [1 .. 12] = 5
/// @param lacunarity how much finer each octave is [1.5 .. 4] = 2
/// @param gain       how much weaker each octave is [0 .. 1] = 0.5
/// @param contrast   contrast around 0.5 [0 .. 4] = 1
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr WorldPos]
fn userProc(scale: f32, octaves: f32, lacunarity: f32, gain: f32, contrast: f32, position: vec4f) -> f32 {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    return saturate(0.5 + 0.5 * contrast * fbm3D(p, clamp(octaves, 1.0, 12.0), lacunarity, gain, pixel));
}
