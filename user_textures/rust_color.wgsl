/// The colour of rust. Broad stains, blistered flakes and fine grain are added up to one number, and the ramp gives
/// it its colour: old, dark scale at 0, fresh orange rust at 1.
/// @param scale  stains per metre [0.01 .. 1000] [soft 1 .. 100] [log] = 12
/// @param ramp   colours from old to fresh rust [smooth] = [(0.0, #170d09), (0.28, #3a1a0e), (0.5, #6b3213), (0.75, #9c4d1d), (1.0, #c98a4b)]
/// @param grain  strength of the fine grain [0 .. 1] [percent] = 0.5
/// @param flakes strength of the flakes [0 .. 1] [percent] = 0.5
/// @group weathering
/// @param position where; link `mapping` or `warp` to change it [attr WorldPos]
fn userProc(scale: f32, ramp: ramp1D, grain: f32, flakes: f32, position: vec4f) -> vec3f {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    // Stains run into each other: the noise is warped by another one.
    let warp = vec3f(perlin3D(p * 0.7), perlin3D(p * 0.7 + 19.1), perlin3D(p * 0.7 + 47.3));
    let stains = 1.148 * fbm3D(p + 0.9 * warp, 6.0, 2.03, 0.55, pixel);
    let speckles = 1.0725 * fbm3D(p * 9.0 + 0.5 * warp, 4.0, 2.03, 0.55, pixel * 9.0);
    // Flakes have ragged edges, and lie in some places only.
    let ragged = vec3f(speckles, perlin3D(p * 7.0 + 3.3), perlin3D(p * 7.0 + 8.1));
    let cell = voronoi3D(p * 1.7 + 0.6 * warp + 0.16 * ragged, 1.0);
    let border = cell.second - cell.nearest;
    let shade = random1to1(cell.id);
    let blistered = smoothstep(-0.1, 0.5, perlin3D(p * 0.45 + 71.0) + 0.4 * stains) * (1.0 - smoothstep(0.15, 0.5, pixel));
    let lift = flakes * blistered * (0.5 * (shade - 0.5) + 0.35 * (smoothstep(0.0, 0.3, border) - 0.6));
    let t = 0.5 + 0.42 * stains + lift + 0.4 * grain * speckles;
    // Pits are deeper than the ramp can say: nearly no light comes back.
    let pits = smoothstep(0.35, 0.75, speckles) * grain;
    // What is too fine to be seen spreads t over the pixel: the deviations of stains, speckles and flakes.
    let spread = smoothstep(vec2f(0.3), vec2f(0.7), vec2f(pixel, pixel * 9.0)) * vec2f(0.076, 0.072 * grain);
    let blisters = 0.06 * flakes * smoothstep(0.15, 0.5, pixel);
    let color = ramp_mean(ramp, t, length(vec3f(spread, blisters)));
    return color * (1.0 - 0.6 * pits);
}

// Mean of the ramp over a bell curve around t (Gauss-Hermite quadrature with three points).
fn ramp_mean(ramp: ramp1D, t: f32, deviation: f32) -> vec3f {
    let middle = rampEval(ramp, saturate(t)).rgb;
    if deviation <= 0.0 {
        return middle;
    }
    let away = 1.7320508 * deviation;
    return (4.0 * middle + rampEval(ramp, saturate(t - away)).rgb + rampEval(ramp, saturate(t + away)).rgb) / 6.0;
}
