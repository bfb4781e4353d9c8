/// Where edges are worn: 1 on bare edges, 0 elsewhere; noise breaks them up. Edges are where the surface is curved outwards, and, on
/// hard edges, where rays into the body soon leave it again: give the node an `occlusion` slot with `direction = "inside"`.
/// @group weathering
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param inside      what is occluded by the body itself [attr AO]
/// @param curvature   1/m, positive on ridges [attr Curvature]
/// @param amount      how far wear reaches [0 .. 1] [percent] = 0.5
/// @param radius      ridges rounder than this do not wear [0.0001 .. 10] [log] [unit m] = 0.05
/// @param use_inside  how much occlusion inside counts: 0 without such a slot [0 .. 2] = 1
/// @param roughness   how much noise breaks it up [0 .. 1] [percent] = 0.6
/// @param scale       of the noise, per metre [0.1 .. 1000] [log] = 18
/// @param contrast    hardness [0 .. 1] [percent] = 0.7
fn userProc(
    position: vec4f,
    inside: f32,
    curvature: f32,
    amount: f32,
    radius: f32,
    use_inside: f32,
    roughness: f32,
    scale: f32,
    contrast: f32,
) -> f32 {
    let pixel = position.w * scale;
    let noise = fbm3D(position.xyz * scale, 5.0, 2.1, 0.55, pixel);
    // Half of a ridge's curvature is enough for an edge; half of the sky is all that an edge of a cube hides.
    let ridge = saturate(2.0 * curvature * radius - 0.5);
    let edge = max(ridge, saturate(2.0 * use_inside * (1.0 - inside)));
    let softness = 0.02 + 0.4 * (1.0 - saturate(contrast));
    let level = edge * (1.0 + roughness * noise) + 0.25 * roughness * noise * smoothstep(0.0, 0.4, edge);
    let border = 1.0 - 0.9 * saturate(amount);
    return smoothstep(border - softness, border + softness, level) * smoothstep(0.0, 0.1, edge);
}
