/// The opposite colour.
/// @group colour
/// @param color  what goes in [color] = #c46a2a
/// @param factor how much [0 .. 1] [percent] = 1
fn userProc(color: vec4f, factor: f32) -> vec4f {
    return vec4f(mix(color.rgb, 1.0 - color.rgb, saturate(factor)), color.a);
}
