/// The foreground, not multiplied by its opacity, over the background.
/// @param fg  foreground = (0, 0, 0, 0)
/// @param bg  background = (0, 0, 0, 0)
/// @param mix share of the foreground = 1
fn userProc(fg: vec4f, bg: vec4f, mix: f32) -> vec4f {
    let sum = vec4f(fg.rgb * fg.a + bg.rgb * (1.0 - fg.a), fg.a + bg.a * (1.0 - fg.a));
    return sum * mix + bg * (1.0 - mix);
}
