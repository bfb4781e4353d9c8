/// The background darkened by the foreground.
/// @param fg  foreground = (0, 0, 0, 0)
/// @param bg  background = (0, 0, 0, 0)
/// @param mix share of the foreground = 1
fn userProc(fg: vec4f, bg: vec4f, mix: f32) -> vec4f {
    let none = abs(fg) < vec4f(1e-8);
    let burnt = 1.0 - (1.0 - bg) / select(fg, vec4f(1.0), none);
    return select(mix * burnt + (1.0 - mix) * bg, vec4f(), none);
}
