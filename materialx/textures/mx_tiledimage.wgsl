/// @use mx_picture
/// An image that repeats; v goes upwards.
/// @param file               the image [data]
/// @param texcoord           where [attr TexCoord0]
/// @param uvtiling           repeats in one unit = (1, 1)
/// @param uvoffset           shift
/// @param realworldimagesize size of the image = (1, 1)
/// @param realworldtilesize  size of what one unit covers = (1, 1)
fn userProc(
    file: sam2D,
    texcoord: vec4f,
    uvtiling: vec2f,
    uvoffset: vec2f,
    realworldimagesize: vec2f,
    realworldtilesize: vec2f,
) -> vec4f {
    let factor = realworldtilesize / max(realworldimagesize, vec2f(1e-6));
    let uv = (texcoord.xy * uvtiling - uvoffset) * factor;
    let stretch = abs(uvtiling * factor);
    return picture(file, vec4f(uv, 0.0, texcoord.w * max(stretch.x, stretch.y)), vec4f(), 0u);
}
