/// From left to right.
/// @param valuel   left = (0, 0, 0, 0)
/// @param valuer   right = (0, 0, 0, 0)
/// @param texcoord where [attr TexCoord0]
fn userProc(valuel: vec4f, valuer: vec4f, texcoord: vec4f) -> vec4f {
    return mix(valuel, valuer, saturate(texcoord.x));
}
