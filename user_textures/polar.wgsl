/// Texture coordinates around a centre: x goes round once (0 to 1), y is the distance from it. Bricks become a round wall,
/// stripes become rays or rings.
/// @group coordinates
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param center what it goes round [soft 0 .. 1] = (0.5, 0.5)
/// @param scale  size of one unit of distance, in uv [0.001 .. 10] [soft 0.1 .. 2] = 0.5
fn userProc(texcoord: vec4f, center: vec2f, scale: f32) -> vec4f {
    let d = texcoord.xy - center;
    let distance = max(length(d), 1e-5);
    let around = atan2(d.y, d.x) / 6.2831853 + 0.5;
    let pixel = texcoord.w * max(1.0 / max(scale, 1e-4), 1.0 / (6.2831853 * distance));
    return vec4f(around, distance / max(scale, 1e-4), 0.0, pixel);
}
