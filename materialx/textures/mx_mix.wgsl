/// From the background to the foreground.
/// @param fg  foreground = (0, 0, 0, 0)
/// @param bg  background = (0, 0, 0, 0)
/// @param mix share of the foreground = (0, 0, 0, 0)
fn userProc(fg: vec4f, bg: vec4f, mix: vec4f) -> vec4f {
    return bg * (1.0 - mix) + fg * mix;
}
