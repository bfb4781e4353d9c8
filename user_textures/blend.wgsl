/// Lays one colour over another, as layers of a picture, with the modes of painting programs.
/// @group colour
/// @param base   the lower colour [color] = #b5653a
/// @param over   the upper colour [color] = #3a6ea5
/// @param factor how much of the upper one [0 .. 1] [percent] = 0.5
/// @param mode   0 mix, 1 darken, 2 multiply, 3 burn, 4 lighten, 5 screen, 6 dodge, 7 add, 8 overlay, 9 soft light, 10 hard light, 11 linear light, 12 difference, 13 exclusion, 14 subtract, 15 divide, 16 hue, 17 saturation, 18 colour, 19 value [0 .. 19] = 2
/// @param limit  whether the result is held between 0 and 1 = false
fn userProc(base: vec4f, over: vec4f, factor: f32, mode: u32, limit: bool) -> vec4f {
    let mixed = mix(base.rgb, blended(base.rgb, over.rgb, mode), saturate(factor));
    return vec4f(select(mixed, saturate(mixed), limit), mix(base.a, over.a, saturate(factor)));
}

fn blended(a: vec3f, b: vec3f, mode: u32) -> vec3f {
    let one = vec3f(1.0);
    let screen = one - (one - a) * (one - b);
    switch mode {
        case 0u: { return b; }
        case 1u: { return min(a, b); }
        case 2u: { return a * b; }
        case 3u: { return one - min((one - min(a, one)) / max(b, vec3f(1e-4)), one); }
        case 4u: { return max(a, b); }
        case 5u: { return screen; }
        case 6u: { return min(a / max(one - b, vec3f(1e-4)), max(one, a)); }
        case 7u: { return a + b; }
        case 8u: { return select(one - 2.0 * (one - a) * (one - b), 2.0 * a * b, a < vec3f(0.5)); }
        case 9u: { return (one - a) * a * b + a * screen; }
        case 10u: { return select(one - 2.0 * (one - a) * (one - b), 2.0 * a * b, b < vec3f(0.5)); }
        case 11u: { return a + 2.0 * b - one; }
        case 12u: { return abs(a - b); }
        case 13u: { return a + b - 2.0 * a * b; }
        case 14u: { return a - b; }
        case 15u: { return a / max(b, vec3f(1e-4)); }
        default: { return by_hue(rgbToHsv(a), rgbToHsv(b), a, mode); }
    }
}

fn by_hue(a: vec3f, b: vec3f, color: vec3f, mode: u32) -> vec3f {
    switch mode {
        // Greys have no hue to give.
        case 16u: { return select(hsvToRgb(vec3f(b.x, a.yz)), color, b.y == 0.0); }
        case 17u: { return select(hsvToRgb(vec3f(a.x, b.y, a.z)), color, a.y == 0.0); }
        case 18u: { return hsvToRgb(vec3f(b.xy, a.z)); }
        default: { return hsvToRgb(vec3f(a.xy, b.z)); }
    }
}
