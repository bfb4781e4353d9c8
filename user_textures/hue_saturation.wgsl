/// Another hue, saturation and brightness for a colour.
/// @group colour
/// @param color      what goes in [color] = #c46a2a
/// @param hue        0.5 leaves it, 0 and 1 are the opposite colour [0 .. 1] = 0.5
/// @param saturation 0 is grey, 1 leaves it [0 .. 2] = 1
/// @param value      factor on the brightness [0 .. 2] = 1
/// @param factor     how much is changed [0 .. 1] [percent] = 1
fn userProc(color: vec4f, hue: f32, saturation: f32, value: f32, factor: f32) -> vec4f {
    let hsv = rgbToHsv(color.rgb);
    let changed = hsvToRgb(vec3f(fract(hsv.x + hue + 0.5), saturate(hsv.y * saturation), hsv.z * value));
    return vec4f(mix(color.rgb, max(changed, vec3f()), saturate(factor)), color.a);
}
