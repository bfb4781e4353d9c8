/// Turns a vector about an axis, as MaterialX's node of that name: places, directions or normals.
/// @group coordinates
/// @param vector what is turned [attr LocalPos]
/// @param amount turn [angle] [-6.2832 .. 6.2832] = 0.7854
/// @param axis   about which it turns = (0, 1, 0)
fn userProc(vector: vec4f, amount: f32, axis: vec3f) -> vec4f {
    let unit = axis / max(length(axis), 1e-6);
    return vec4f(rotateAxis(vector.xyz, unit, amount), vector.w);
}
