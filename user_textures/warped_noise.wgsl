/// Fractal noise pushed about by itself (Quilez 2002): swirls as of ink in water. x is the noise, y and z what pushed it: good for a
/// second colour.
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale      features per metre [0.01 .. 1000] [soft 0.5 .. 20] [log] = 2.5
/// @param distortion how far it is pushed, in features [0 .. 4] = 1.2
/// @param octaves    finer details on coarse ones [1 .. 12] = 5
fn userProc(position: vec4f, scale: f32, distortion: f32, octaves: f32) -> vec3f {
    let p = position.xyz * scale;
    let pixel = position.w * scale * (1.0 + distortion);
    let shown = clamp(octaves, 1.0, 12.0);
    let push = fbmVector3D(p, min(shown, 4.0), 2.0, 0.5, pixel);
    let value = fbm3D(p + distortion * push, shown, 2.0, 0.5, pixel);
    return saturate(0.5 + 0.85 * vec3f(value, push.xy));
}
