/// One value at the top, one at the bottom.
/// @param valuet   top = (0, 0, 0, 0)
/// @param valueb   bottom = (0, 0, 0, 0)
/// @param center   where one becomes the other = 0.5
/// @param texcoord where [attr TexCoord0]
fn userProc(valuet: vec4f, valueb: vec4f, center: f32, texcoord: vec4f) -> vec4f {
    return mix(valueb, valuet, edgeStep(center, texcoord.y, texcoord.w));
}
