/// From 0 to 1, without a kink at either end.
/// @param in   what goes in = (0, 0, 0, 0)
/// @param low  least = (0, 0, 0, 0)
/// @param high most = (1, 1, 1, 1)
fn userProc(in: vec4f, low: vec4f, high: vec4f) -> vec4f {
    let range = high - low;
    let t = saturate((in - low) / select(range, vec4f(1.0), range == vec4f()));
    let smoothed = t * t * (3.0 - 2.0 * t);
    return select(select(smoothed, vec4f(1.0), in >= high), vec4f(), in < low);
}
