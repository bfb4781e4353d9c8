/// Goes from one number to another.
/// @group colour
/// @param a      value where the factor is 0 = 0
/// @param b      value where the factor is 1 = 1
/// @param factor how much of b [0 .. 1] [percent] = 0.5
/// @param limit  whether the factor is held between 0 and 1 = true
fn userProc(a: f32, b: f32, factor: f32, limit: bool) -> f32 {
    return mix(a, b, select(factor, saturate(factor), limit));
}
