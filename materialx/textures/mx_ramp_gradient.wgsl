fn interval(t: f32, low: f32, high: f32, from_color: vec4f, to_color: vec4f, interpolation: u32) -> vec4f {
    let range = high - low;
    let share = select((clamp(t, min(low, high), max(low, high)) - low) / select(range, 1.0, range == 0.0), 0.0, range == 0.0);
    switch interpolation {
        case 0u: { return mix(from_color, to_color, share); }
        case 1u: { return mix(from_color, to_color, select(share * share * (3.0 - 2.0 * share), 1.0, t >= high)); }
        default: { return select(to_color, from_color, high > t); }
    }
}

/// One interval of a ramp.
/// @param x             where = 0
/// @param interval1     beginning = 0
/// @param interval2     end = 1
/// @param color1        colour at the beginning = (0, 0, 0, 1)
/// @param color2        colour at the end = (1, 1, 1, 1)
/// @param interpolation 0 linear, 1 smooth, 2 in steps = 1
/// @param prev_color    colour before the beginning = (0, 0, 0, 1)
/// @param interval_num  number of the interval = 1
/// @param num_intervals how many there are = 2
fn userProc(
    x: f32,
    interval1: f32,
    interval2: f32,
    color1: vec4f,
    color2: vec4f,
    interpolation: u32,
    prev_color: vec4f,
    interval_num: u32,
    num_intervals: u32,
) -> vec4f {
    if interval_num >= num_intervals || x <= interval1 {
        return prev_color;
    }
    return interval(x, interval1, interval2, color1, color2, interpolation);
}
