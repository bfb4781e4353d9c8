/// @use mx_picture
/// An image; v goes upwards.
/// @param file          the image [data]
/// @param default_value what is shown outside where the address mode is constant = (0, 0, 0, 0)
/// @param texcoord      where [attr TexCoord0]
/// @param bounds        1 nothing left and right of the image, 2 nothing above and below it, 3 both = 0
fn userProc(file: sam2D, default_value: vec4f, texcoord: vec4f, bounds: u32) -> vec4f {
    return picture(file, texcoord, default_value, bounds);
}
