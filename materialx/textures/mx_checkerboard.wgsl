/// Squares of two colours.
/// @param color1   colour of the first squares = (1, 1, 1, 1)
/// @param color2   colour of the others = (0, 0, 0, 0)
/// @param uvtiling repeats in one unit = (8, 8)
/// @param uvoffset shift
/// @param texcoord where [attr TexCoord0]
fn userProc(color1: vec4f, color2: vec4f, uvtiling: vec2f, uvoffset: vec2f, texcoord: vec4f) -> vec4f {
    let p = floor(texcoord.xy * uvtiling - uvoffset);
    return mix(color2, color1, modulo(p.x + p.y, 2.0));
}
