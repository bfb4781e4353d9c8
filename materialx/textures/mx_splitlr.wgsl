/// One value left, one right.
/// @param valuel   left = (0, 0, 0, 0)
/// @param valuer   right = (0, 0, 0, 0)
/// @param center   where one becomes the other = 0.5
/// @param texcoord where [attr TexCoord0]
fn userProc(valuel: vec4f, valuer: vec4f, center: f32, texcoord: vec4f) -> vec4f {
    return mix(valuel, valuer, edgeStep(center, texcoord.x, texcoord.w));
}
