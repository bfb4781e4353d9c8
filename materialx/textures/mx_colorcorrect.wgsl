/// @use mx_hsv
/// Corrections of a colour, one after the other.
/// @param in            what goes in = (1, 1, 1, 1)
/// @param hue           added to the hue = 0
/// @param saturation    factor on the saturation = 1
/// @param gamma         exponent = 1
/// @param lift          added to what is dark = 0
/// @param gain          factor on what is bright = 1
/// @param contrast      contrast = 1
/// @param contrastpivot what contrast leaves as it is = 0.5
/// @param exposure      stops = 0
fn userProc(
    in: vec4f,
    hue: f32,
    saturation: f32,
    gamma: f32,
    lift: f32,
    gain: f32,
    contrast: f32,
    contrastpivot: f32,
    exposure: f32,
) -> vec4f {
    let hsv = toHsv(in.rgb);
    var c = fromHsv(vec3f(hsv.x + hue, hsv.yz));
    c = mix(vec3f(dot(c, vec3f(0.2722287, 0.6740818, 0.0536895))), c, saturation);
    c = sign(c) * pow(max(abs(c), vec3f(1e-38)), vec3f(1.0 / max(gamma, 1e-6)));
    c = (c * (1.0 - lift) + lift) * gain;
    c = (c - contrastpivot) * contrast + contrastpivot;
    return vec4f(c * exp2(exposure), in.a);
}
