/// How far a surface faces the viewer: 1 straight on, 0 at its rim.
/// @param normal      shading normal [attr Normal]
/// @param faceforward whether both sides count = true
/// @param invert      whether the rim is 1 = false
fn userProc(normal: vec3f, faceforward: bool, invert: bool) -> f32 {
    let c = dot(readAttr(ViewDir).xyz, normal);
    let ratio = select(c, abs(c), faceforward);
    return select(ratio, 1.0 - ratio, invert);
}
