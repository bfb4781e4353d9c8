/// @use mx_picture
/// Three images, projected along x, y and z.
/// @param filex    image along x [data]
/// @param filey    image along y [data]
/// @param filez    image along z [data]
/// @param position where [attr LocalPos]
/// @param normal   which way the surface looks [attr LocalNormal]
/// @param upaxis   what is up: 0 x, 1 y, 2 z = 2
/// @param blend    how soft they run into each other = 1
fn userProc(
    filex: sam2D,
    filey: sam2D,
    filez: sam2D,
    position: vec4f,
    normal: vec3f,
    upaxis: u32,
    blend: f32,
) -> vec4f {
    let p = position.xyz;
    let size = abs(normal) / max(length(normal), 1e-30);
    let bent = pow(size / max(dot(size, vec3f(1.0)), 1e-30), vec3f(1.0 / clamp(blend, 0.03, 1.0)));
    let weights = bent / max(dot(bent, vec3f(1.0)), 1e-30);
    let x = select(p.zy, p.yz, upaxis == 2u);
    let y = select(p.xz, p.zx, upaxis == 0u);
    let z = select(p.xy, vec2f(-p.y, p.x), upaxis == 0u);
    return weights.x * picture(filex, vec4f(x, 0.0, position.w), vec4f(), 0u)
        + weights.y * picture(filey, vec4f(y, 0.0, position.w), vec4f(), 0u)
        + weights.z * picture(filez, vec4f(z, 0.0, position.w), vec4f(), 0u);
}
