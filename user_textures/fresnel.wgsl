/// What a smooth surface of this refractive index reflects, unpolarised: little where it faces the viewer, all at its rim.
/// @group surface
/// @param ior    refractive index: water 1.33, glass 1.5, diamond 2.42 [1 .. 4] = 1.5
/// @param normal of the surface [attr Normal]
fn userProc(ior: f32, normal: vec3f) -> f32 {
    let cosine = saturate(abs(dot(normal, readAttr(ViewDir).xyz)));
    let n = max(ior, 1.0001);
    let g = sqrt(max(n * n - 1.0 + cosine * cosine, 0.0));
    let a = (g - cosine) / (g + cosine);
    let b = (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0);
    return saturate(0.5 * a * a * (1.0 + b * b));
}
