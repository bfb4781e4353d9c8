/// @use mx_picture
/// An image with the transform of glTF, times two colours; the fourth component is the opacity.
/// @param file           the image [data]
/// @param default_value  what is shown outside where the address mode is constant = (0, 0, 0, 0)
/// @param texcoord       where [attr TexCoord0]
/// @param pivot          what stays where it is = (0, 1)
/// @param scale          repeats = (1, 1)
/// @param rotate         degrees = 0
/// @param offset         shift
/// @param operationorder 0 scale, turn, shift; 1 shift, turn, scale = 0
/// @param color          factor = (1, 1, 1, 1)
/// @param geomcolor      another factor = (1, 1, 1, 1)
/// @param bounds         1 nothing left and right of the image, 2 nothing above and below it, 3 both = 0
fn userProc(
    file: sam2D,
    default_value: vec4f,
    texcoord: vec4f,
    pivot: vec2f,
    scale: vec2f,
    rotate: f32,
    offset: vec2f,
    operationorder: u32,
    color: vec4f,
    geomcolor: vec4f,
    bounds: u32,
) -> vec4f {
    let at = placed(texcoord, pivot, scale, rotate, offset, operationorder);
    return color * geomcolor * picture(file, at, default_value, bounds);
}
