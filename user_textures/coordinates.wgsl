/// A place to look other textures up at: link it to their `position` or `texcoord`. Its fourth component is the width of the
/// pixel there.
/// @group coordinates
/// @param space 0 the object's own, 1 the world, 2 first texture coordinates, 3 second ones [0 .. 3] = 0
fn userProc(space: u32) -> vec4f {
    let pixel = readAttr(Footprint);
    if space == 1u {
        return vec4f(readAttr(WorldPos).xyz, pixel.x);
    }
    if space == 2u {
        return vec4f(readAttr(TexCoord0).xy, 0.0, pixel.y);
    }
    if space == 3u {
        return vec4f(readAttr(TexCoord1).xy, 0.0, pixel.y);
    }
    return vec4f(readAttr(LocalPos).xyz, pixel.z);
}
