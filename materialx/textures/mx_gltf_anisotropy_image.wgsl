/// @use mx_picture
/// Strength and turn of an anisotropy, in radians, from an image with the transform of glTF.
/// @param file                the image [data]
/// @param default_value       what is shown outside where the address mode is constant = (1, 0.5, 1, 0)
/// @param texcoord            where [attr TexCoord0]
/// @param pivot               what stays where it is = (0, 1)
/// @param scale               repeats = (1, 1)
/// @param rotate              degrees = 0
/// @param offset              shift
/// @param anisotropy_strength factor on the strength = 1
/// @param anisotropy_rotation added to the turn = 0
/// @param bounds              1 nothing left and right of the image, 2 nothing above and below it, 3 both = 0
fn userProc(
    file: sam2D,
    default_value: vec4f,
    texcoord: vec4f,
    pivot: vec2f,
    scale: vec2f,
    rotate: f32,
    offset: vec2f,
    anisotropy_strength: f32,
    anisotropy_rotation: f32,
    bounds: u32,
) -> vec4f {
    let at = placed(texcoord, pivot, scale, rotate, offset, 0u);
    let found = picture(file, at, default_value, bounds);
    let way = 2.0 * found.xy - 1.0;
    let turn = select(atan2(way.y, way.x), 0.0, all(way == vec2f()));
    return vec4f(anisotropy_strength * found.z, anisotropy_rotation + turn, 0.0, 0.0);
}
