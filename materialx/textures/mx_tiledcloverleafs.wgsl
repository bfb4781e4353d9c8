/// @use mx_shapes
/// Fours of disks in rows.
/// @param texcoord  where [attr TexCoord0]
/// @param uvtiling  repeats in one unit = (1, 1)
/// @param uvoffset  shift
/// @param size      size = 0.5
/// @param staggered whether each second row is shifted = false
fn userProc(texcoord: vec4f, uvtiling: vec2f, uvoffset: vec2f, size: f32, staggered: bool) -> vec4f {
    let p = texcoord.xy * uvtiling - uvoffset;
    if !staggered {
        return vec4f(cloverleaf(2.0 * fract(p) - 1.0, size));
    }
    let height = 0.5;
    let shift = select(0.0, 0.5, modulo(p.y, 2.0 * height) > height);
    let q = vec2f(fract(p.x + shift), modulo(p.y, height));
    let half = 0.5 * size;
    let upper = cloverleaf(vec2f(q.x - 0.5, height - q.y), half);
    return vec4f(max(max(cloverleaf(q, half), cloverleaf(vec2f(1.0 - q.x, q.y), half)), upper));
}
