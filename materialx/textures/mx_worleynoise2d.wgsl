/// @use mx_worley
/// Distances to the three nearest of randomly placed points, or random numbers of the nearest one's cell.
/// @param texcoord where [attr TexCoord0]
/// @param jitter   how irregular = 1
/// @param style    0 distances, 1 a number for each cell = 0
fn userProc(texcoord: vec4f, jitter: f32, style: u32) -> vec4f {
    return vec4f(worley2(texcoord.xy, jitter, style == 1u), 0.0);
}
