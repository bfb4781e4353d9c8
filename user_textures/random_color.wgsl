/// A random colour for each object, or for each value that is linked: around a mean, as people tint things.
/// @group random
/// @param value      what the colour depends on; link a cell's or a tile's number [attr ObjectRandom]
/// @param color      the mean [color] = #a4663f
/// @param hue        how far hues differ; 1 is all of them [0 .. 1] [percent] = 0.06
/// @param saturation how far saturations differ [0 .. 1] [percent] = 0.25
/// @param brightness how far brightnesses differ [0 .. 1] [percent] = 0.35
/// @param seed       other colours [seed] = 0
fn userProc(value: f32, color: vec3f, hue: f32, saturation: f32, brightness: f32, seed: u32) -> vec3f {
    let r = 2.0 * randomOf(vec4f(value, 0.0, 0.0, f32(seed))) - 1.0;
    let hsv = rgbToHsv(color);
    let changed = vec3f(fract(hsv.x + 0.5 * hue * r.x), hsv.y * (1.0 + saturation * r.y), hsv.z * (1.0 + brightness * r.z));
    return hsvToRgb(vec3f(changed.x, saturate(changed.y), max(changed.z, 0.0)));
}
