/// Long streaks in one direction, as rain on walls or wear on floors: 0 to 1.
/// @group weathering
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param direction along the streaks = (0, 1, 0)
/// @param scale     streaks per metre [0.1 .. 1000] [log] = 20
/// @param length    length of a streak over its width [1 .. 200] [log] = 25
/// @param amount    how much [0 .. 1] [percent] = 0.5
/// @param contrast  hardness [0 .. 1] [percent] = 0.4
fn userProc(position: vec4f, direction: vec3f, scale: f32, length: f32, amount: f32, contrast: f32) -> f32 {
    let n = direction / max(sqrt(dot(direction, direction)), 1e-6);
    let along = dot(position.xyz, n);
    let p = (position.xyz + n * along * (1.0 / max(length, 1.0) - 1.0)) * scale;
    let pixel = position.w * scale;
    let fine = fbm3D(p, 5.0, 2.1, 0.6, pixel);
    let broad = fbm3D(p * 0.2 + 7.0, 3.0, 2.0, 0.5, pixel * 0.2);
    let level = 0.5 + 0.5 * fine + 0.5 * broad;
    // What the pixel hides of both noises is in the width, by their spread.
    let hidden = 0.19 * (1.0 - fractalSeen(5.0, 2.1, 0.6, pixel));
    let hidden_broad = 0.22 * (1.0 - fractalSeen(3.0, 2.0, 0.5, pixel * 0.2));
    let widths = vec3f(mix(0.5, 0.05, saturate(contrast)), hidden, hidden_broad);
    let width = sqrt(dot(widths, widths));
    let edge = 1.0 - saturate(amount);
    return smoothstep(edge - width, edge + width, level);
}
