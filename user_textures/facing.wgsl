/// How much the surface is turned away from the viewer: 0 where it faces, 1 at its rim. For velvet, dust and rims of light.
/// @group surface
/// @param blend  0.5 is plain; more widens the rim, less narrows it [0 .. 1] = 0.5
/// @param normal of the surface [attr Normal]
fn userProc(blend: f32, normal: vec3f) -> f32 {
    let facing = saturate(abs(dot(normal, readAttr(ViewDir).xyz)));
    let b = clamp(blend, 0.0, 0.999);
    let exponent = select(0.5 / (1.0 - b), 2.0 * b, b < 0.5);
    return 1.0 - pow(max(facing, 1e-6), max(exponent, 1e-3));
}
