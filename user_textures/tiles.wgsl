/// Tiles with rounded corners, as MaterialX's tiled patterns: x is 1 on a tile and 0 in the joint, y the height with a bevel, z a
/// random number of the tile.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param uvtiling tiles per unit of uv [soft 1 .. 40] = (6, 6)
/// @param offset   shift of each row, in tiles [0 .. 1] = 0
/// @param joint    width of the joints, in tiles [0 .. 0.5] = 0.05
/// @param corner   radius of the corners, in tiles [0 .. 0.5] = 0.06
/// @param bevel    width of the slope at the border, in tiles [0 .. 0.5] = 0.05
fn userProc(texcoord: vec4f, uvtiling: vec2f, offset: f32, joint: f32, corner: f32, bevel: f32) -> vec3f {
    let tiling = max(abs(uvtiling), vec2f(1e-3));
    var p = texcoord.xy * tiling;
    p.x += offset * modulo(floor(p.y), 2.0);
    let pixel = texcoord.w * max(tiling.x, tiling.y);
    let cell = floor(p);
    let d = abs(p - cell - 0.5) - (0.5 - 0.5 * joint - corner);
    let distance = length(max(d, vec2f())) + min(max(d.x, d.y), 0.0) - corner;
    let mask = 1.0 - edgeStep(0.0, distance, pixel);
    let height = smoothstep(0.0, max(bevel, 1e-4), -distance);
    let number = random2to1(vec2u(vec2i(cell)));
    // A square less its corners, and the mean over it of the smooth slope.
    let side = 1.0 - joint;
    let flat_corner = max(corner - 0.5 * bevel, 0.0);
    let area = saturate(side * side - 0.858 * corner * corner);
    let mean = saturate(side * side - 2.0 * side * bevel + 1.2 * bevel * bevel - 0.858 * flat_corner * flat_corner);
    return mix(vec3f(area, mean, 0.5), vec3f(mask, height, number), octaveSeen(0.6 * pixel));
}
