/// Cracks in mud, glaze or old paint: x is 1 in a crack, y the distance from it in plates, z a random number of the plate.
/// @group materials
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale  plates per metre [0.01 .. 1000] [log] = 5
/// @param width  of the cracks, in plates [0 .. 0.5] = 0.035
/// @param fray   how ragged the cracks are [0 .. 1] [percent] = 0.5
/// @param fine   whether finer cracks run through the plates [0 .. 1] [percent] = 0.5
fn userProc(position: vec4f, scale: f32, width: f32, fray: f32, fine: f32) -> vec3f {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    let q = p + 0.3 * fray * fbmVector3D(p * 1.5, 4.0, 2.2, 0.6, pixel);
    let edge = voronoiEdge3D(q, 1.0);
    let id = voronoi3D(q, 1.0).id;
    let finer = voronoiEdge3D(q * 3.1 + 7.0, 1.0) / 3.1;
    let half = 0.5 * width;
    let wide = half * (0.7 + 0.6 * perlin3D(p * 3.0));
    let crack = 1.0 - softStep(wide * 0.6, wide + 0.004, edge, pixel);
    // Fine cracks don't reach everywhere.
    let here = smoothstep(0.15, -0.25, perlin3D(p * 0.7 + 3.0)) * fine;
    let thin = (1.0 - softStep(0.15 * half, 0.35 * half + 0.003, finer, pixel)) * here * 0.7;
    let seen = octaveSeen(0.5 * pixel);
    let mean = vec3f(saturate(2.2 * width), 0.125, 0.5);
    return mix(mean, vec3f(saturate(max(crack, thin)), edge, random1to1(id)), seen);
}
