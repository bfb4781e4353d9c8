/// The foreground over a background that it shares no pixel with.
/// @param fg  foreground = (0, 0, 0, 0)
/// @param bg  background = (0, 0, 0, 0)
/// @param mix share of the foreground = 1
fn userProc(fg: vec4f, bg: vec4f, mix: f32) -> vec4f {
    let sum = fg.a + bg.a;
    let none = abs(bg.a) < 1e-8;
    let share = select((1.0 - fg.a) / select(bg.a, 1.0, none), 1.0, sum <= 1.0);
    let rgb = select(fg.rgb + bg.rgb * share, vec3f(), none && sum > 1.0);
    return mix * vec4f(rgb, min(sum, 1.0)) + (1.0 - mix) * bg;
}
