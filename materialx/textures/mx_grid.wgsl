/// Lines along both axes.
/// @param texcoord  where [attr TexCoord0]
/// @param uvtiling  repeats in one unit = (1, 1)
/// @param uvoffset  shift
/// @param thickness thickness = 0.05
/// @param staggered whether each second row is shifted = false
fn userProc(texcoord: vec4f, uvtiling: vec2f, uvoffset: vec2f, thickness: f32, staggered: bool) -> vec4f {
    let p = texcoord.xy * uvtiling - uvoffset;
    let shift = select(0.0, 0.5, staggered && modulo(p.y, 2.0) > 1.0);
    let inside = abs(2.0 * fract(p + vec2f(shift, 0.0)) - 1.0);
    return vec4f(select(0.0, 1.0, any(inside > vec2f(1.0 - thickness))));
}
