/// Dark parts multiplied, bright ones screened.
/// @param fg  foreground = (0, 0, 0, 0)
/// @param bg  background = (0, 0, 0, 0)
/// @param mix share of the foreground = 1
fn userProc(fg: vec4f, bg: vec4f, mix: f32) -> vec4f {
    let dark = 2.0 * fg * bg;
    let bright = 1.0 - 2.0 * (1.0 - bg) * (1.0 - fg);
    return mix * select(dark, bright, bg >= vec4f(0.5)) + (1.0 - mix) * bg;
}
