/// From 0 to 1 over a distance, as Blender's node of that name.
/// @group patterns
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param kind   0 linear, 1 quadratic, 2 eased, 3 diagonal, 4 spherical, 5 quadratic sphere, 6 radial [0 .. 6] = 0
/// @param axis   along which it rises; for radial ones, which it goes round = (0, 1, 0)
/// @param start  where it begins on the axis [soft -2 .. 2] [unit m] = -0.5
/// @param length over which it rises [0.0001 .. 1000] [soft 0.05 .. 5] [log] [unit m] = 1
fn userProc(position: vec4f, kind: u32, axis: vec3f, start: f32, length: f32) -> f32 {
    let n = axis / max(sqrt(dot(axis, axis)), 1e-6);
    let p = position.xyz;
    let t = (dot(p, n) - start) / max(length, 1e-6);
    switch kind {
        case 1u: { return saturate(t) * saturate(t); }
        case 2u: { return smoothstep(0.0, 1.0, t); }
        case 3u: { return saturate((0.5 * (p.x + p.y) - start) / max(length, 1e-6)); }
        case 4u: { return saturate(1.0 - sqrt(dot(p, p)) / max(length, 1e-6)); }
        case 5u: {
            let s = saturate(1.0 - sqrt(dot(p, p)) / max(length, 1e-6));
            return s * s;
        }
        case 6u: {
            // Two directions across the axis.
            let side = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 0.0, 1.0), abs(n.x) > 0.7);
            let u = normalize(cross(n, side));
            let v = cross(n, u);
            return atan2(dot(p, v), dot(p, u) + 1e-12) / 6.2831853 + 0.5;
        }
        default: { return saturate(t); }
    }
}
