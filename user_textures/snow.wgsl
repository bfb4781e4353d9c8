/// Snow on what looks up, with frayed borders: x is the cover (0 or 1, soft at its border), y the thickness for `bump`.
/// @group weathering
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param normal   which way the surface looks, in the world [attr Normal]
/// @param open     how open it lies: snow doesn't fall under things [attr AO]
/// @param up       where snow comes from = (0, 1, 0)
/// @param amount   how much [0 .. 1] [percent] = 0.5
/// @param slope    steepest slope that holds it [angle] [0 .. 1.5708] = 0.9
/// @param scale    of the borders, per metre [0.1 .. 1000] [log] = 6
/// @param softness width of the borders [0 .. 1] [percent] = 0.15
fn userProc(
    position: vec4f,
    normal: vec3f,
    open: f32,
    up: vec3f,
    amount: f32,
    slope: f32,
    scale: f32,
    softness: f32,
) -> vec2f {
    let pixel = position.w * scale;
    let height = dot(normal, up) / max(length(up), 1e-6);
    let noise = fbm3D(position.xyz * scale, 6.0, 2.1, 0.5, pixel);
    let level = height + 0.35 * noise - 0.5 * (1.0 - open) + 0.5 * (amount - 0.5);
    let edge = cos(slope);
    // What the pixel hides of the noise is in the width, by its spread.
    let width = length(vec2f(0.01 + 0.5 * softness, 0.14 * (1.0 - fractalSeen(6.0, 2.1, 0.5, pixel))));
    let cover = smoothstep(edge - width, edge + width, level);
    let thickness = smoothstep(edge, edge + 0.6, level) * (0.8 + 0.2 * noise);
    return vec2f(cover, saturate(thickness));
}
