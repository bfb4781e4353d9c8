/// @use mx_picture
/// A panorama in a direction.
/// @param file     the image [data]
/// @param viewdir  the direction = (0, 0, 1)
/// @param rotation degrees = 0
fn userProc(file: sam2D, viewdir: vec3f, rotation: f32) -> vec4f {
    let around = select(atan2(viewdir.x, viewdir.z), 0.0, all(viewdir.xz == vec2f()));
    let u = 0.00277778 * rotation + 0.5 - 0.15915494 * around;
    let v = 0.5 + 0.31830989 * asin(clamp(viewdir.y, -1.0, 1.0));
    let mirrored = 1.0 - abs(1.0 - modulo(v, 2.0));
    return picture(file, vec4f(u, mirrored, 0.0, 0.0), vec4f(), 0u);
}
