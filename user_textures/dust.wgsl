/// Dust that has settled on what looks up: 0 is clean, 1 is covered. Linked to the blend of two materials, or to a colour.
/// @group weathering
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param normal    which way the surface looks, in the world [attr Normal]
/// @param up        where dust comes from = (0, 1, 0)
/// @param amount    how much [0 .. 1] [percent] = 0.6
/// @param slope     steepest slope that holds it [angle] [0 .. 1.5708] = 1.05
/// @param scale     of the noise, per metre [0.1 .. 1000] [log] = 12
/// @param roughness how much noise breaks it up [0 .. 1] [percent] = 0.5
fn userProc(position: vec4f, normal: vec3f, up: vec3f, amount: f32, slope: f32, scale: f32, roughness: f32) -> f32 {
    let pixel = position.w * scale;
    let height = dot(normal, up) / max(length(up), 1e-6);
    let flat = smoothstep(cos(min(slope + 0.35, 3.1)), cos(max(slope - 0.5, 0.0)), height);
    let noise = fbm3D(position.xyz * scale, 5.0, 2.0, 0.55, pixel);
    let specks = fbm3D(position.xyz * scale * 9.0, 3.0, 2.0, 0.6, pixel * 9.0);
    return saturate(flat * amount * (1.0 + roughness * (1.1 * noise + 0.6 * specks)));
}
