/// Four values in the corners.
/// @param valuetl  top left = (0, 0, 0, 0)
/// @param valuetr  top right = (0, 0, 0, 0)
/// @param valuebl  bottom left = (0, 0, 0, 0)
/// @param valuebr  bottom right = (0, 0, 0, 0)
/// @param texcoord where [attr TexCoord0]
fn userProc(valuetl: vec4f, valuetr: vec4f, valuebl: vec4f, valuebr: vec4f, texcoord: vec4f) -> vec4f {
    let t = saturate(texcoord.xy);
    return mix(mix(valuebl, valuebr, t.x), mix(valuetl, valuetr, t.x), t.y);
}
