/// @use mx_picture
/// An image with a factor and an addition; v goes upwards.
/// @param file     the image [data]
/// @param fallback what is shown outside where the address mode is constant = (0, 0, 0, 1)
/// @param st       where [attr TexCoord0]
/// @param scale    factor = (1, 1, 1, 1)
/// @param bias     what is added = (0, 0, 0, 0)
/// @param bounds   1 nothing left and right of the image, 2 nothing above and below it, 3 both = 0
fn userProc(file: sam2D, fallback: vec4f, st: vec4f, scale: vec4f, bias: vec4f, bounds: u32) -> vec4f {
    return picture(file, st, fallback, bounds) * scale + bias;
}
