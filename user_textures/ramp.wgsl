/// A colour ramp: any number of colours along a factor.
/// @group colour
/// @param t     where on the ramp [0 .. 1] [attr TexCoord0]
/// @param stops colours [smooth] = [(0, #1b2a49), (0.35, #465c8b), (0.6, #d9826b), (0.85, #f6c65b), (1, #fff3c9)]
fn userProc(t: f32, stops: ramp1D) -> vec4f {
    return rampEval(stops, t);
}
