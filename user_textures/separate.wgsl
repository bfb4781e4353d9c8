/// A colour's hue, saturation and value, or other parts of it: link to `.x`, `.y` or `.z`.
/// @group colour
/// @param color what is taken apart [color] = #c46a2a
/// @param mode  0 red, green, blue, 1 hue, saturation, value, 2 hue, saturation, lightness, 3 Oklab [0 .. 3] = 1
fn userProc(color: vec4f, mode: u32) -> vec4f {
    switch mode {
        case 1u: { return vec4f(rgbToHsv(color.rgb), color.a); }
        case 2u: { return vec4f(rgbToHsl(color.rgb), color.a); }
        case 3u: { return vec4f(rgbToOklab(color.rgb), color.a); }
        default: { return color; }
    }
}
