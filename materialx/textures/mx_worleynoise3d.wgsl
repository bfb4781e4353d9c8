/// @use mx_worley
/// Distances to the three nearest of randomly placed points, or random numbers of the nearest one's cell.
/// @param position where [attr LocalPos]
/// @param jitter   how irregular = 1
/// @param style    0 distances, 1 a number for each cell = 0
fn userProc(position: vec4f, jitter: f32, style: u32) -> vec4f {
    return vec4f(worley3(position.xyz, jitter, style == 1u), 0.0);
}
