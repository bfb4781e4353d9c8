fn interval(t: f32, low: f32, high: f32, from_color: vec4f, to_color: vec4f, interpolation: u32) -> vec4f {
    let range = high - low;
    let share = select((clamp(t, min(low, high), max(low, high)) - low) / select(range, 1.0, range == 0.0), 0.0, range == 0.0);
    switch interpolation {
        case 0u: { return mix(from_color, to_color, share); }
        case 1u: { return mix(from_color, to_color, select(share * share * (3.0 - 2.0 * share), 1.0, t >= high)); }
        default: { return select(to_color, from_color, high > t); }
    }
}

/// Up to ten colours along a line, around a point or outwards.
/// @param texcoord      where [attr TexCoord0]
/// @param kind          0 along u, 1 radial, 2 circular, 3 a box = 0
/// @param interpolation 0 linear, 1 smooth, 2 in steps = 1
/// @param num_intervals how many of the colours count = 2
/// @param interval1     place of colour 1 = 0
/// @param color1        colour 1 = (0, 0, 0, 1)
/// @param interval2     place of colour 2 = 1
/// @param color2        colour 2 = (1, 1, 1, 1)
/// @param interval3     place of colour 3 = 1
/// @param color3        colour 3 = (1, 1, 1, 1)
/// @param interval4     place of colour 4 = 1
/// @param color4        colour 4 = (1, 1, 1, 1)
/// @param interval5     place of colour 5 = 1
/// @param color5        colour 5 = (1, 1, 1, 1)
/// @param interval6     place of colour 6 = 1
/// @param color6        colour 6 = (1, 1, 1, 1)
/// @param interval7     place of colour 7 = 1
/// @param color7        colour 7 = (1, 1, 1, 1)
/// @param interval8     place of colour 8 = 1
/// @param color8        colour 8 = (1, 1, 1, 1)
/// @param interval9     place of colour 9 = 1
/// @param color9        colour 9 = (1, 1, 1, 1)
/// @param interval10    place of colour 10 = 1
/// @param color10       colour 10 = (1, 1, 1, 1)
fn userProc(
    texcoord: vec4f,
    kind: u32,
    interpolation: u32,
    num_intervals: u32,
    interval1: f32,
    color1: vec4f,
    interval2: f32,
    color2: vec4f,
    interval3: f32,
    color3: vec4f,
    interval4: f32,
    color4: vec4f,
    interval5: f32,
    color5: vec4f,
    interval6: f32,
    color6: vec4f,
    interval7: f32,
    color7: vec4f,
    interval8: f32,
    color8: vec4f,
    interval9: f32,
    color9: vec4f,
    interval10: f32,
    color10: vec4f,
) -> vec4f {
    let p = texcoord.xy - 0.5;
    var t = texcoord.x;
    switch kind {
        case 1u: { t = select(atan2(p.x, p.y) / 6.28319, 0.0, all(p == vec2f())) + 0.5; }
        case 2u: { t = length(1.414 * p); }
        case 3u: { t = 2.0 * max(abs(p.x), abs(p.y)); }
        default: {}
    }
    var result = color1;
    if num_intervals > 1u && t > interval1 {
        result = interval(t, interval1, interval2, color1, color2, interpolation);
    }
    if num_intervals > 2u && t > interval2 {
        result = interval(t, interval2, interval3, color2, color3, interpolation);
    }
    if num_intervals > 3u && t > interval3 {
        result = interval(t, interval3, interval4, color3, color4, interpolation);
    }
    if num_intervals > 4u && t > interval4 {
        result = interval(t, interval4, interval5, color4, color5, interpolation);
    }
    if num_intervals > 5u && t > interval5 {
        result = interval(t, interval5, interval6, color5, color6, interpolation);
    }
    if num_intervals > 6u && t > interval6 {
        result = interval(t, interval6, interval7, color6, color7, interpolation);
    }
    if num_intervals > 7u && t > interval7 {
        result = interval(t, interval7, interval8, color7, color8, interpolation);
    }
    if num_intervals > 8u && t > interval8 {
        result = interval(t, interval8, interval9, color8, color9, interpolation);
    }
    if num_intervals > 9u && t > interval9 {
        result = interval(t, interval9, interval10, color9, color10, interpolation);
    }
    return result;
}
