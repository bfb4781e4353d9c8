/// @use mx_jenkins
/// @use mx_hsv
/// A random colour.
/// @param in             what goes in = 0
/// @param huelow         least hue = 0
/// @param huehigh        most hue = 1
/// @param saturationlow  least saturation = 0.825
/// @param saturationhigh most saturation = 1
/// @param brightnesslow  least brightness = 1
/// @param brightnesshigh most brightness = 1
/// @param seed           another one = 0
fn userProc(
    in: f32,
    huelow: f32,
    huehigh: f32,
    saturationlow: f32,
    saturationhigh: f32,
    brightnesslow: f32,
    brightnesshigh: f32,
    seed: i32,
) -> vec4f {
    let s = f32(seed);
    let x = 4096.0 * in;
    let random = vec3f(cell2(vec2f(x, ceil(s + 413.3))), cell2(vec2f(x, ceil(s + 1522.4))), cell2(vec2f(x, ceil(s + 1813.8))));
    let low = vec3f(huelow, saturationlow, brightnesslow);
    let high = vec3f(huehigh, saturationhigh, brightnesshigh);
    return vec4f(fromHsv(mix(low, high, random)), 1.0);
}
