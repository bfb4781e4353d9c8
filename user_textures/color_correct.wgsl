/// All that is done to a colour to fit it in, in the order of MaterialX's node of that name.
/// @group colour
/// @param color         what goes in [color] = #8a6a4f
/// @param hue           shift; 1 goes round once [-1 .. 1] = 0
/// @param saturation    0 is grey, 1 leaves it [0 .. 2] = 1
/// @param gamma         brightens the middle [0.1 .. 5] [log] = 1
/// @param lift          brightens the dark [-1 .. 1] = 0
/// @param gain          factor on all [0 .. 4] = 1
/// @param contrast      1 leaves it [0 .. 4] = 1
/// @param contrastpivot what contrast leaves as it is [0 .. 1] = 0.18
/// @param exposure      stops [-8 .. 8] = 0
fn userProc(
    color: vec4f,
    hue: f32,
    saturation: f32,
    gamma: f32,
    lift: f32,
    gain: f32,
    contrast: f32,
    contrastpivot: f32,
    exposure: f32,
) -> vec4f {
    let hsv = rgbToHsv(max(color.rgb, vec3f()));
    var c = hsvToRgb(vec3f(fract(hsv.x + hue), hsv.y, hsv.z));
    c = mix(vec3f(luminance(c)), c, saturation);
    c = pow(max(c, vec3f()), vec3f(1.0 / max(gamma, 1e-3)));
    c = c * (1.0 - lift) + lift;
    c = (c * gain - contrastpivot) * contrast + contrastpivot;
    return vec4f(c * exp2(exposure), color.a);
}
