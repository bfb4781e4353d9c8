/// Turned by degrees, clockwise.
/// @param in     what is turned [attr TexCoord0]
/// @param amount degrees = 0
fn userProc(in: vec4f, amount: f32) -> vec4f {
    return vec4f(rotate2D(in.xy, -radians(amount)), in.zw);
}
