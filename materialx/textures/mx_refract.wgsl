/// A direction refracted by a surface; 0 where nothing goes through.
/// @param in     what goes in = (1, 0, 0)
/// @param normal shading normal [attr Normal]
/// @param ior    ratio of the refractive indices = 1
fn userProc(in: vec3f, normal: vec3f, ior: f32) -> vec3f {
    let c = dot(in, normal);
    let k = 1.0 - ior * ior * (1.0 - c * c);
    if k < 0.0 {
        return vec3f();
    }
    return ior * in - (ior * c + sqrt(k)) * normal;
}
