/// The second texture coordinates with v upwards; their fourth component is the width of the pixel.
/// @param uv where [attr TexCoord1]
fn userProc(uv: vec4f) -> vec4f {
    return vec4f(uv.x, 1.0 - uv.y, 0.0, uv.w);
}
