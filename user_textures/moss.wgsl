/// Moss in damp places: in creases, and on what looks up. The colour with cushions of different greens; the fourth component is
/// where it grows, for a blend.
/// @group weathering
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param normal which way the surface looks, in the world [attr Normal]
/// @param open   how open it lies [attr AO]
/// @param amount how much [0 .. 1] [percent] = 0.5
/// @param scale  cushions per metre [0.1 .. 1000] [log] = 14
/// @param young  colour of young moss [color] = #8fa83a
/// @param old    colour of old moss [color] = #2c3d14
fn userProc(position: vec4f, normal: vec3f, open: f32, amount: f32, scale: f32, young: vec3f, old: vec3f) -> vec4f {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    let patches = fbm3D(p * 0.3, 5.0, 2.1, 0.55, pixel * 0.3);
    let up = 0.5 + 0.5 * normal.y;
    let damp = 0.55 * up + 1.2 * (1.0 - open) + 0.8 * patches;
    // Cushions are domes; short stalks stand out of them.
    let round = 1.0 - voronoiSmooth3D(p + 0.3 * perlin3D(p * 1.7), 1.0, 0.3);
    let dome = mix(0.46, round, octaveSeen(0.5 * pixel));
    let stalks = fbm3D(p * 9.0, 3.0, 2.2, 0.6, pixel * 9.0);
    let edge = mix(1.2, -0.3, saturate(amount));
    // What the pixel hides is in the width, by its spread.
    let width = length(vec2f(0.08, 0.31 * (1.0 - octaveSeen(pixel))));
    let cover = smoothstep(edge - width, edge + width, damp + 0.25 * (dome - 0.5) + 0.12 * stalks);
    let shade = saturate(0.2 + 0.7 * dome + 0.6 * stalks + 0.3 * patches);
    return vec4f(mix(old, young, shade * shade), cover);
}
