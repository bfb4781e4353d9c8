/// Four colours in the corners of uv, mixed between, as MaterialX's node of that name.
/// @group colour
/// @param valuetl top left [color] = #e8c170
/// @param valuetr top right [color] = #c06a3d
/// @param valuebl bottom left [color] = #3c6e71
/// @param valuebr bottom right [color] = #24344d
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
fn userProc(valuetl: vec4f, valuetr: vec4f, valuebl: vec4f, valuebr: vec4f, texcoord: vec4f) -> vec4f {
    let t = saturate(texcoord.xy);
    return mix(mix(valuetl, valuetr, t.x), mix(valuebl, valuebr, t.x), t.y);
}
