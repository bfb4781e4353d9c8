/// The brightness of a colour, as the eye weighs red, green and blue.
/// @group colour
/// @param color what goes in [color] = #c46a2a
fn userProc(color: vec4f) -> f32 {
    return luminance(color.rgb);
}
