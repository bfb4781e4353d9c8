/// The background brightened by the foreground.
/// @param fg  foreground = (0, 0, 0, 0)
/// @param bg  background = (0, 0, 0, 0)
/// @param mix share of the foreground = 1
fn userProc(fg: vec4f, bg: vec4f, mix: f32) -> vec4f {
    let none = abs(1.0 - fg) < vec4f(1e-8);
    let dodged = bg / select(1.0 - fg, vec4f(1.0), none);
    return select(mix * dodged + (1.0 - mix) * bg, vec4f(), none);
}
