/// Winds texture coordinates up around a centre.
/// @group coordinates
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param center  what it turns about [soft 0 .. 1] = (0.5, 0.5)
/// @param angle   turn in the centre [angle] [-31.416 .. 31.416] = 3.1416
/// @param radius  where the turn ends, in uv [0.001 .. 10] [soft 0.05 .. 1] = 0.5
fn userProc(texcoord: vec4f, center: vec2f, angle: f32, radius: f32) -> vec4f {
    let d = texcoord.xy - center;
    let t = saturate(1.0 - length(d) / max(radius, 1e-4));
    let uv = rotate2D(d, angle * t * t) + center;
    return vec4f(uv, texcoord.z, texcoord.w * (1.0 + abs(angle) * t));
}
