//! Hue, saturation and value: as the standard functions have them, but for colours of any size.

fn toHsv(rgb: vec3f) -> vec3f {
    let most = max(rgb.r, max(rgb.g, rgb.b));
    let delta = most - min(rgb.r, min(rgb.g, rgb.b));
    if delta <= 0.0 || most <= 0.0 {
        return vec3f(0.0, 0.0, most);
    }
    var hue = 4.0 + (rgb.r - rgb.g) / delta;
    if rgb.r >= most {
        hue = (rgb.g - rgb.b) / delta;
    } else if rgb.g >= most {
        hue = 2.0 + (rgb.b - rgb.r) / delta;
    }
    return vec3f(fract(hue / 6.0), delta / most, most);
}

fn fromHsv(hsv: vec3f) -> vec3f {
    if hsv.y < 0.0001 {
        return vec3f(hsv.z);
    }
    let h = 6.0 * fract(hsv.x);
    let f = fract(h);
    let low = hsv.z * (1.0 - hsv.y);
    let falling = hsv.z * (1.0 - hsv.y * f);
    let rising = hsv.z * (1.0 - hsv.y * (1.0 - f));
    switch u32(h) {
        case 0u: { return vec3f(hsv.z, rising, low); }
        case 1u: { return vec3f(falling, hsv.z, low); }
        case 2u: { return vec3f(low, hsv.z, rising); }
        case 3u: { return vec3f(low, falling, hsv.z); }
        case 4u: { return vec3f(rising, low, hsv.z); }
        default: { return vec3f(hsv.z, low, falling); }
    }
}
