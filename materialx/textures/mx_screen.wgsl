/// As two projectors on one screen.
/// @param fg  foreground = (0, 0, 0, 0)
/// @param bg  background = (0, 0, 0, 0)
/// @param mix share of the foreground = 1
fn userProc(fg: vec4f, bg: vec4f, mix: f32) -> vec4f {
    return mix * (1.0 - (1.0 - fg) * (1.0 - bg)) + (1.0 - mix) * bg;
}
