/// Plaster laid on with a trowel: shallow strokes that overlap, and grains. The height, 0 to 1, for `bump`; good at 2 to 10 mm.
/// @group materials
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale  strokes per metre [0.1 .. 1000] [log] = 5
/// @param strokes strength of the strokes [0 .. 1] [percent] = 0.7
/// @param grain  strength of the grains [0 .. 1] [percent] = 0.3
fn userProc(position: vec4f, scale: f32, strokes: f32, grain: f32) -> f32 {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    let q = p + 0.4 * fbmVector3D(p * 0.6, 3.0, 2.0, 0.5, pixel);
    var height = 0.0;
    for (var layer = 0; layer < 3; layer++) {
        // A stroke is a plane with its own tilt; the highest stroke is on top.
        let cell = voronoi3D(q * (1.0 + 0.35 * f32(layer)) + 11.0 * f32(layer), 1.0);
        let tilt = 2.0 * random1to3(cell.id) - 1.0;
        height = max(height, 0.45 + 0.3 * dot(tilt, cell.toNearest) + 0.25 * (unitFloat(cell.id) - 0.5));
    }
    let coarse = mix(0.55, height, strokes * octaveSeen(pixel));
    let grains = fbm3D(p * 14.0, 4.0, 2.1, 0.6, pixel * 14.0);
    return saturate(coarse + 0.16 * grain * grains);
}
