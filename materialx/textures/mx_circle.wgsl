/// @use mx_shapes
/// A disk.
/// @param texcoord where [attr TexCoord0]
/// @param center   its middle
/// @param radius   radius = 0.5
fn userProc(texcoord: vec4f, center: vec2f, radius: f32) -> f32 {
    return circle(texcoord.xy - center, radius);
}
