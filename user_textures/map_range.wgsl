/// A number of one range in another one.
/// @group colour
/// @param value         what goes in [attr TexCoord0]
/// @param from_min      lower end of its range = 0
/// @param from_max      upper end of its range = 1
/// @param to_min        what the lower end becomes = 0
/// @param to_max        what the upper end becomes = 1
/// @param interpolation 0 linear, 1 stepped, 2 smooth, 3 smoother [0 .. 3] = 0
/// @param steps         how many steps stepped ones have [1 .. 100] = 4
/// @param clamp_result  whether it stays in the new range = true
fn userProc(
    value: f32,
    from_min: f32,
    from_max: f32,
    to_min: f32,
    to_max: f32,
    interpolation: u32,
    steps: f32,
    clamp_result: bool,
) -> f32 {
    var t = remap(value, from_min, from_max, 0.0, 1.0);
    if interpolation == 1u {
        t = floor(t * (steps + 1.0)) / max(steps, 1.0);
    } else if interpolation == 2u {
        t = smoothstep(0.0, 1.0, t);
    } else if interpolation == 3u {
        t = smootherstep(0.0, 1.0, t);
    }
    let kept = select(t, saturate(t), clamp_result);
    return to_min + kept * (to_max - to_min);
}
