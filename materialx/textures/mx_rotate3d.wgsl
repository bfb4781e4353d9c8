/// Turned about an axis by degrees.
/// @param in     what is turned [attr LocalPos]
/// @param amount degrees = 0
/// @param axis   about which it turns = (0, 1, 0)
fn userProc(in: vec4f, amount: f32, axis: vec3f) -> vec4f {
    let unit = axis / max(length(axis), 1e-30);
    return vec4f(rotateAxis(in.xyz, unit, -radians(amount)), in.w);
}
