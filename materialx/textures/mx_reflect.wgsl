/// A direction mirrored by a surface.
/// @param in     what goes in = (1, 0, 0)
/// @param normal shading normal [attr Normal]
fn userProc(in: vec3f, normal: vec3f) -> vec3f {
    return in - 2.0 * dot(normal, in) * normal;
}
