/// @use mx_hsv
/// Another hue, saturation and value.
/// @param in     what goes in = (0, 0, 0, 0)
/// @param amount added to the hue, factors on saturation and value = (0, 1, 1)
fn userProc(in: vec4f, amount: vec3f) -> vec4f {
    let hsv = toHsv(in.rgb);
    return vec4f(fromHsv(vec3f(hsv.x + amount.x, hsv.yz * amount.yz)), in.a);
}
