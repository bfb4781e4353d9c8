/// @use mx_worley
/// The distance to the nearest of randomly placed points, or a random number of its cell.
/// @param texcoord where [attr TexCoord0]
/// @param jitter   how irregular = 1
/// @param style    0 distances, 1 a number for each cell = 0
fn userProc(texcoord: vec4f, jitter: f32, style: u32) -> f32 {
    return worleyOf1_2(texcoord.xy, jitter, style == 1u);
}
