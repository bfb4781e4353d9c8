/// @use mx_shapes
/// Four disks.
/// @param texcoord where [attr TexCoord0]
/// @param center   its middle
/// @param radius   radius = 0.5
fn userProc(texcoord: vec4f, center: vec2f, radius: f32) -> f32 {
    return cloverleaf(texcoord.xy - center, radius);
}
