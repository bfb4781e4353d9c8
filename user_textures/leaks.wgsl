/// Stains that run down from edges above: 0 is clean, 1 is stained. On walls below ledges, rivets and windows.
/// @group weathering
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param normal  which way the surface looks, in the world; floors have none [attr Normal]
/// @param columns drops beside each other per metre [0.1 .. 1000] [log] = 12
/// @param length  of a stain [0.01 .. 100] [log] [unit m] = 1
/// @param amount  share of the places where one runs [0 .. 1] [percent] = 0.5
/// @param top     height where they begin; stains repeat below each `length` [unit m] = 0.5
fn userProc(position: vec4f, normal: vec3f, columns: f32, length: f32, amount: f32, top: f32) -> f32 {
    // Along the wall, whichever way it looks; a stain wavers as it goes down.
    let p = position.xyz;
    let pixel = position.w * columns;
    let wall = 1.0 - smoothstep(0.5, 0.85, abs(normal.y));
    let down = (top - p.y) / max(length, 1e-3);
    let waver = 0.35 * perlin3D(vec3f(p.xz * columns * 0.5, p.y * 3.0));
    let along = select(p.z, p.x, abs(normal.z) >= abs(normal.x)) * columns + waver;
    var untouched = 1.0;
    for (var layer = 0; layer < 2; layer++) {
        let x = along * (1.0 + 0.7 * f32(layer)) + 17.3 * f32(layer);
        let column = floor(x);
        let r = random2to3(vec2u(vec2i(vec2f(column, f32(layer)))));
        let reach = 0.25 + 0.75 * r.y;
        let inside = 1.0 - abs(2.0 * fract(x) - 1.0);
        let run = fract(down) / reach;
        let fade = saturate(1.0 - run) * smoothstep(0.0, 0.02, fract(down));
        let width = saturate(inside * (1.6 - run) * 1.3);
        untouched *= 1.0 - step(r.x, amount) * fade * width * (0.5 + 0.5 * r.z);
    }
    let grain = 0.75 + 0.4 * fbm3D(vec3f(p.x, 0.15 * p.y, p.z) * columns * 3.0, 4.0, 2.0, 0.6, pixel * 3.0);
    let stain = saturate((1.0 - untouched) * grain);
    return wall * mix(0.2 * amount, stain, octaveSeen(0.7 * pixel));
}
