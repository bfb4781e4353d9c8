/// Where metal rusts: 0 is clean, 1 is rust. Rust comes in noisy patches and grows in crevices, where water stays:
/// there ambient occlusion is strong. The node's `occlusion` names the AO slot; its distance is how far rust
/// creeps out of a crevice.
/// @param scale     patches per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 4
/// @param amount    how much of an open surface rusts [0 .. 1] [percent] = 0.3
/// @param influence how strongly crevices attract rust [0 .. 4] = 1.5
/// @param contrast  hardness of the edges: 0 is soft [0 .. 1] = 0.7
/// @group weathering
/// @param position where; link `mapping` or `warp` to change it [attr WorldPos]
fn userProc(scale: f32, amount: f32, influence: f32, contrast: f32, position: vec4f) -> f32 {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    // Patches, with edges that fray: the coarse noise is pushed about by a finer one.
    let fray = vec3f(perlin3D(p * 2.7), perlin3D(p * 2.7 + 11.3), perlin3D(p * 2.7 + 23.9));
    let patches = 1.148 * fbm3D(p + 0.25 * fray, 6.0, 2.03, 0.55, pixel);
    // Rust begins in crevices and, with time, runs out of them: the noise decides how far.
    let occluded = 1.0 - readAttr(AO).x;
    let crevice = influence * occluded * (0.6 + 0.6 * patches);
    // The noise is spread about 0 like a bell: the logistic threshold makes `amount` the area that rusts.
    let covered = clamp(amount, 0.0005, 0.9995);
    let threshold = 0.13 * log((1.0 - covered) / covered);
    // Patches too small to be seen leave a soft threshold behind: their mean.
    let hidden = 0.39 * (1.0 - fractalSeen(6.0, 2.03, 0.55, pixel));
    let softness = length(vec2f(0.015 + 0.3 * (1.0 - saturate(contrast)), hidden));
    return smoothstep(threshold - softness, threshold + softness, patches + crevice);
}
