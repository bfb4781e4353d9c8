/// Leather: small cushions with folds between them, and pores. The colour, darker in the folds; the fourth component is the
/// height, for `bump`.
/// @group materials
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale cushions per metre [1 .. 10000] [soft 50 .. 1000] [log] = 45
/// @param color of the leather [color] = #6b3a20
/// @param folds colour in the folds [color] = #2a140b
/// @param wear  how irregular and worn it is [0 .. 1] [percent] = 0.5
fn userProc(position: vec4f, scale: f32, color: vec3f, folds: vec3f, wear: f32) -> vec4f {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    let q = p + 0.35 * fbmVector3D(p * 0.5, 3.0, 2.0, 0.5, pixel);
    let large = voronoiEdge3D(q, 0.95);
    let fine = voronoi3D(q * 2.7, 1.0);
    let cushion = smoothstep(0.0, 0.28, large);
    let small = smoothstep(0.0, 0.3, fine.second - fine.nearest);
    let pore = 1.0 - smoothstep(0.06, 0.12, fine.nearest + 0.05 * f32(fine.id & 1u));
    let region = fbm3D(p * 0.06, 4.0, 2.0, 0.5, pixel * 0.06);
    let seen = octaveSeen(0.7 * pixel);
    let height = mix(0.36, cushion * (0.75 + 0.25 * small) - 0.3 * pore, seen);
    let shade = saturate(height + wear * 0.45 * region);
    return vec4f(mix(folds, color * (1.0 + 0.5 * wear * region), smoothstep(0.0, 0.75, shade)), saturate(height));
}
