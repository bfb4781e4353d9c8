/// Dirt where it gathers: in creases and corners (the node's `occlusion` names the AO slot) and, a little, anywhere. 0 is
/// clean, 1 is dirt.
/// @group weathering
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param open     how open it lies [attr AO]
/// @param amount   how much [0 .. 1] [percent] = 0.5
/// @param anywhere dirt in open places [0 .. 1] [percent] = 0.7
/// @param scale    of the stains, per metre [0.01 .. 1000] [log] = 5
/// @param contrast hardness [0 .. 1] [percent] = 0.35
fn userProc(position: vec4f, open: f32, amount: f32, anywhere: f32, scale: f32, contrast: f32) -> f32 {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    let stains = fbm3D(p + 0.4 * perlin3D(p * 2.3), 6.0, 2.1, 0.6, pixel);
    let specks = fbm3D(p * 7.0 + 5.0, 3.0, 2.1, 0.6, pixel * 7.0);
    let crease = 1.0 - saturate(open);
    let level = crease * (1.2 + stains) + anywhere * (0.45 + 0.9 * stains + 0.35 * specks);
    // What the pixel hides of both noises is in the width, by their spread.
    let hidden = (1.0 - fractalSeen(6.0, 2.1, 0.6, pixel)) * 0.36 * (crease + 0.9 * anywhere);
    let hidden_specks = (1.0 - fractalSeen(3.0, 2.1, 0.6, pixel * 7.0)) * 0.15 * anywhere;
    let width = length(vec3f(mix(0.6, 0.06, saturate(contrast)), hidden, hidden_specks));
    let edge = mix(1.1, 0.05, saturate(amount));
    return smoothstep(edge - width, edge + width, level);
}
