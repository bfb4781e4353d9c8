/// @use mx_picture
/// The thickness of a film from an image with the transform of glTF.
/// @param file          the image [data]
/// @param default_value what is shown outside where the address mode is constant = (0, 0, 0, 0)
/// @param texcoord      where [attr TexCoord0]
/// @param pivot         what stays where it is
/// @param scale         repeats = (1, 1)
/// @param rotate        degrees = 0
/// @param offset        shift
/// @param thicknessmin  nanometres where the image is 1 = 100
/// @param thicknessmax  nanometres where it is 0 = 400
/// @param bounds        1 nothing left and right of the image, 2 nothing above and below it, 3 both = 0
fn userProc(
    file: sam2D,
    default_value: vec4f,
    texcoord: vec4f,
    pivot: vec2f,
    scale: vec2f,
    rotate: f32,
    offset: vec2f,
    thicknessmin: f32,
    thicknessmax: f32,
    bounds: u32,
) -> f32 {
    let at = placed(texcoord, pivot, scale, rotate, offset, 0u);
    return mix(thicknessmax, thicknessmin, picture(file, at, default_value, bounds).y);
}
