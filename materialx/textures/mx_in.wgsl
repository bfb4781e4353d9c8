/// The foreground where the background is.
/// @param fg  foreground = (0, 0, 0, 0)
/// @param bg  background = (0, 0, 0, 0)
/// @param mix share of the foreground = 1
fn userProc(fg: vec4f, bg: vec4f, mix: f32) -> vec4f {
    return fg * bg.a * mix + bg * (1.0 - mix);
}
