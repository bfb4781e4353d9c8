/// Paint that peels: x is 1 where paint is left, y the height of its curled rims for `bump`, z a random tint of the flake.
/// @group weathering
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale    flakes per metre [0.1 .. 1000] [log] = 9
/// @param amount   how much has gone [0 .. 1] [percent] = 0.4
/// @param cracks   width of the cracks, in flakes [0 .. 0.3] = 0.03
fn userProc(position: vec4f, scale: f32, amount: f32, cracks: f32) -> vec3f {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    let q = p + 0.35 * fbmVector3D(p * 0.8, 4.0, 2.2, 0.55, pixel);
    let found = voronoi3D(q, 0.9);
    let border = found.second - found.nearest;
    let number = random1to1(found.id);
    // Flakes go where others have gone.
    let region = fbm3D(p * 0.3 + 3.0, 4.0, 2.1, 0.5, pixel * 0.3);
    let loose = 0.5 + 0.45 * region + 0.5 * (number - 0.5) + 0.15 * fbm3D(q * 3.0, 3.0, 2.2, 0.6, pixel * 3.0);
    let left = loose - saturate(amount);
    let width = 0.015 + 0.5 * pixel * 0.1;
    let stays = smoothstep(-width, width, left);
    let crack = softStep(0.5 * cracks, cracks + 0.02, border, pixel);
    let paint = stays * crack;
    // Paint lifts where it will go next.
    let curl = smoothstep(0.25, 0.0, left) * smoothstep(0.25, 0.0, border);
    let seen = octaveSeen(0.6 * pixel);
    // On the whole `loose` is spread like a bell about 0.5, and cracks leave out what lies near the borders.
    let mean = smoothstep(-0.4, 0.4, 0.5 - saturate(amount)) * exp(-2.7 * cracks - 0.036);
    return mix(vec3f(mean, 0.55 * mean, 0.5), vec3f(paint, paint * (0.5 + 0.5 * curl), number), seen);
}
