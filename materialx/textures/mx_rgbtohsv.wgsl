/// @use mx_hsv
/// Hue, saturation and value of a colour.
/// @param in what goes in = (0, 0, 0, 0)
fn userProc(in: vec4f) -> vec4f {
    return vec4f(toHsv(in.rgb), in.a);
}
