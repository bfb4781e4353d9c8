/// Concrete: clouds of light and dark cement, fine sand, and holes that air has left. The fourth component is the height, for `bump`.
/// @group materials
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale    clouds per metre [0.01 .. 1000] [log] = 2.5
/// @param color    of dry cement [color] = #9d9a94
/// @param contrast of the clouds [0 .. 2] = 1
/// @param holes    share of the surface with holes [0 .. 1] [percent] = 0.3
/// @param grain    strength of the sand [0 .. 1] [percent] = 0.5
fn userProc(position: vec4f, scale: f32, color: vec3f, contrast: f32, holes: f32, grain: f32) -> vec4f {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    let clouds = fbm3D(p + 0.5 * perlin3D(p * 1.3), 6.0, 2.1, 0.55, pixel);
    let patches = fbm3D(p * 0.35 + 13.0, 3.0, 2.0, 0.5, pixel * 0.35);
    let sand = fbm3D(p * 50.0, 2.0, 2.0, 0.6, pixel * 50.0);
    // Bubbles of two sizes, round, in some of the cells.
    var hole = 0.0;
    for (var layer = 0; layer < 2; layer++) {
        let s = 9.0 + 16.0 * f32(layer);
        let cell = voronoi3D(p * s + 7.0 * f32(layer), 0.8);
        let r = random1to2(cell.id);
        let size = 0.1 + 0.22 * r.y;
        let round = 1.0 - softStep(size * 0.75, size, cell.nearest, pixel * s);
        hole = max(hole, select(0.0, round, r.x < 0.6 * holes) * octaveSeen(pixel * s));
    }
    let tone = 1.0 + contrast * (0.22 * clouds + 0.16 * patches) + 0.14 * grain * sand;
    let shade = tone * (1.0 - 0.62 * hole);
    return vec4f(max(color * shade, vec3f()), saturate(0.7 + 0.08 * clouds + 0.1 * grain * sand - 0.65 * hole));
}
