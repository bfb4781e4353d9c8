/// @use mx_hsv
/// The colour of a hue, saturation and value.
/// @param in what goes in = (0, 0, 0, 0)
fn userProc(in: vec4f) -> vec4f {
    return vec4f(fromHsv(in.rgb), in.a);
}
