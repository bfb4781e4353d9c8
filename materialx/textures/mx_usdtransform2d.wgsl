/// Texture coordinates scaled, turned counterclockwise and shifted.
/// @param in          where [attr TexCoord0]
/// @param rotation    degrees = 0
/// @param scale       factor = (1, 1)
/// @param translation shift
fn userProc(in: vec4f, rotation: f32, scale: vec2f, translation: vec2f) -> vec4f {
    let uv = rotate2D(in.xy * scale, radians(rotation)) + translation;
    return vec4f(uv, 0.0, in.w * max(abs(scale.x), abs(scale.y)));
}
