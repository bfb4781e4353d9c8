/// Goes from one colour to another. Link the factor to a mask, the colours to other textures.
/// @param a      colour where the factor is 0 [color] = (0, 0, 0, 1)
/// @param b      colour where the factor is 1 [color] = (1, 1, 1, 1)
/// @param factor how much of b [0 .. 1] [percent] = 0.5
/// @group colour
fn userProc(a: vec4f, b: vec4f, factor: f32) -> vec4f {
    return mix(a, b, saturate(factor));
}
