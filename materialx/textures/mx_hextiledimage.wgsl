/// @use mx_hextile
/// An image that doesn't show that it repeats.
/// @param file            the image [data]
/// @param texcoord        where [attr TexCoord0]
/// @param tiling          repeats = (1, 1)
/// @param rotation        how much hexagons are turned = 1
/// @param rotationrange   between these, in degrees = (0, 360)
/// @param scale           how much they are scaled = 1
/// @param scalerange      between these = (0.5, 2)
/// @param offset          how much they are shifted = 1
/// @param offsetrange     between these = (0, 1)
/// @param falloff         how sharp borders are = 0.5
/// @param falloffcontrast how much the brighter part wins = 0.5
/// @param lumacoeffs      brightness of a colour = (0.2722287, 0.6740818, 0.0536895)
fn userProc(
    file: sam2D,
    texcoord: vec4f,
    tiling: vec2f,
    rotation: f32,
    rotationrange: vec2f,
    scale: f32,
    scalerange: vec2f,
    offset: f32,
    offsetrange: vec2f,
    falloff: f32,
    falloffcontrast: f32,
    lumacoeffs: vec3f,
) -> vec4f {
    let tile = hexTile(texcoord, tiling, rotation, rotationrange, scale, scalerange, offset, offsetrange);
    let a = picture(file, tile.at[0], vec4f(), 0u);
    let b = picture(file, tile.at[1], vec4f(), 0u);
    let c = picture(file, tile.at[2], vec4f(), 0u);
    let luma = vec3f(dot(a.rgb, lumacoeffs), dot(b.rgb, lumacoeffs), dot(c.rgb, lumacoeffs));
    let w = hexWeights(mix(vec3f(1.0), luma, falloffcontrast), tile.nearness, falloff);
    let alpha = dot(hexWeights(vec3f(1.0), tile.nearness, falloff), vec3f(a.a, b.a, c.a));
    return vec4f(w.x * a.rgb + w.y * b.rgb + w.z * c.rgb, alpha);
}
