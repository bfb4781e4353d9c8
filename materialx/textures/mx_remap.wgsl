fn remapped(x: vec4f, in_low: vec4f, in_high: vec4f, out_low: vec4f, out_high: vec4f) -> vec4f {
    let range = in_high - in_low;
    let none = range == vec4f();
    let share = select((x - in_low) / select(range, vec4f(1.0), none), vec4f(), none);
    return out_low + (out_high - out_low) * share;
}

/// From one range to another.
/// @param in      what goes in = (0, 0, 0, 0)
/// @param inlow   least that goes in = (0, 0, 0, 0)
/// @param inhigh  most that goes in = (1, 1, 1, 1)
/// @param outlow  what the least becomes = (0, 0, 0, 0)
/// @param outhigh what the most becomes = (1, 1, 1, 1)
fn userProc(in: vec4f, inlow: vec4f, inhigh: vec4f, outlow: vec4f, outhigh: vec4f) -> vec4f {
    return remapped(in, inlow, inhigh, outlow, outhigh);
}
