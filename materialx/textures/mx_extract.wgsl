/// One component.
/// @param in    what goes in = (0, 0, 0, 0)
/// @param index which component = 0
fn userProc(in: vec4f, index: u32) -> f32 {
    return in[min(index, 3u)];
}
