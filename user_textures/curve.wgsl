/// A number through a curve.
/// @group colour
/// @param value  what goes in [attr TexCoord0]
/// @param factor how much the curve does [0 .. 1] [percent] = 1
/// @param points the curve [smooth] = [(0, (0, 0, 0)), (0.3, (0.1, 0.1, 0.1)), (0.7, (0.9, 0.9, 0.9)), (1, (1, 1, 1))]
fn userProc(value: f32, factor: f32, points: ramp1D) -> f32 {
    return mix(value, rampEval(points, value).x, factor);
}
