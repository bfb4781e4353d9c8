/// Terrazzo: chips of stone in cement, ground flat. The colour; the fourth component is 1 on a chip.
/// @group materials
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param size   of a large chip [0.0005 .. 1] [log] [unit m] = 0.07
/// @param cement colour between the chips [color] = #dcd7cd
/// @param chips  colours of the chips [constant] = [(0, #8c3b2a), (0.25, #c9a27a), (0.45, #4f5d5a), (0.65, #e8e2d6), (0.85, #2e2c2b)]
/// @param fill   share of the chips [0 .. 1] [percent] = 0.7
fn userProc(position: vec4f, size: f32, cement: vec3f, chips: ramp1D, fill: f32) -> vec4f {
    // What chips finer than the pixel are on the whole.
    var mean = vec3f();
    for (var k = 0; k < 5; k++) {
        mean += 0.2 * rampEval(chips, 0.2 * f32(k) + 0.1).rgb;
    }
    var color = cement;
    var chip = 0.0;
    // Small chips lie between large ones.
    for (var layer = 0; layer < 3; layer++) {
        let s = pow(1.9, f32(2 - layer)) / max(size, 1e-6);
        let p = position.xyz * s + 13.0 * f32(layer);
        let pixel = position.w * s;
        let q = p + 0.08 * perlin3D(p * 3.0);
        let edge = voronoiEdge3D(q, 0.9);
        let r = random1to3(voronoi3D(q, 0.9).id);
        let inside = edgeStep(0.07 + 0.14 * r.z, edge, pixel);
        let seen = octaveSeen(0.6 * pixel);
        let cover = mix(0.3 * fill, select(0.0, inside, r.x < 0.75 * fill), seen);
        let own = rampEval(chips, r.y).rgb * (1.0 + 0.2 * perlin3D(p * 6.0) * octaveSeen(pixel * 6.0));
        color = mix(color, mix(mean, own, seen), cover);
        chip = 1.0 - (1.0 - chip) * (1.0 - cover);
    }
    return vec4f(max(color, vec3f()), chip);
}
