/// @use mx_worley
/// The distance to the nearest of randomly placed points, or a random number of its cell.
/// @param position where [attr LocalPos]
/// @param jitter   how irregular = 1
/// @param style    0 distances, 1 a number for each cell = 0
fn userProc(position: vec4f, jitter: f32, style: u32) -> f32 {
    return worleyOf1_3(position.xyz, jitter, style == 1u);
}
