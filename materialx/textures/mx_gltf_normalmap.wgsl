/// @use mx_picture
/// A normal of the surface from a normal map with the transform of glTF.
/// @param file           the image [data]
/// @param default_value  what is shown outside where the address mode is constant = (0.5, 0.5, 1, 0)
/// @param texcoord       where [attr TexCoord0]
/// @param pivot          what stays where it is = (0, 1)
/// @param scale          repeats = (1, 1)
/// @param rotate         degrees = 0
/// @param offset         shift
/// @param operationorder 0 scale, turn, shift; 1 shift, turn, scale = 0
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
    bounds: u32,
) -> vec3f {
    let at = placed(texcoord, pivot, scale, rotate, offset, operationorder);
    let v = 2.0 * picture(file, at, default_value, bounds).rgb - 1.0;
    let sum = readAttr(Tangent).xyz * v.x + readAttr(Bitangent).xyz * v.y + readAttr(Normal).xyz * v.z;
    return sum / max(length(sum), 1e-30);
}
