/// Hexagons with joints: x is 1 on a hexagon and 0 in the joint, y the distance from its border (0.5 in the middle), z a random
/// number of it.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param scale hexagons per unit of uv [0.1 .. 1000] [soft 1 .. 50] [log] = 8
/// @param joint width of the joints, in hexagons [0 .. 0.5] = 0.06
fn userProc(texcoord: vec4f, scale: f32, joint: f32) -> vec3f {
    let p = texcoord.xy * scale;
    let pixel = texcoord.w * scale;
    // Two grids of rectangles have the centres; the nearer one counts.
    let size = vec2f(1.0, 1.7320508);
    let a = floor(p / size) + 0.5;
    let b = floor(p / size - 0.5) + 1.0;
    let to_a = p - a * size;
    let to_b = p - b * size;
    let first = dot(to_a, to_a) < dot(to_b, to_b);
    let d = abs(select(to_b, to_a, first));
    let edge = 0.5 - max(d.x, 0.5 * d.x + 0.8660254 * d.y);
    let cell = select(2.0 * b, 2.0 * a, first);
    let mask = edgeStep(0.5 * joint, edge, pixel);
    let number = random2to1(vec2u(vec2i(cell)));
    let side = 1.0 - joint;
    return mix(vec3f(side * side, 0.167, 0.5), vec3f(mask, edge, number), octaveSeen(0.5 * pixel));
}
