/// Four numbers as one vector or colour: what links can take apart, this puts together.
/// @group colour
/// @param x first, or red = 0
/// @param y second, or green = 0
/// @param z third, or blue = 0
/// @param w fourth, or opacity = 1
/// @param mode 0 as they are, 1 hue, saturation, value, 2 hue, saturation, lightness, 3 Oklab [0 .. 3] = 0
fn userProc(x: f32, y: f32, z: f32, w: f32, mode: u32) -> vec4f {
    let v = vec3f(x, y, z);
    switch mode {
        case 1u: { return vec4f(hsvToRgb(v), w); }
        case 2u: { return vec4f(hslToRgb(v), w); }
        case 3u: { return vec4f(max(oklabToRgb(v), vec3f()), w); }
        default: { return vec4f(v, w); }
    }
}
