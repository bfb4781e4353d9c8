/// From top to bottom.
/// @param valuet   top = (0, 0, 0, 0)
/// @param valueb   bottom = (0, 0, 0, 0)
/// @param texcoord where [attr TexCoord0]
fn userProc(valuet: vec4f, valueb: vec4f, texcoord: vec4f) -> vec4f {
    return mix(valueb, valuet, saturate(texcoord.y));
}
