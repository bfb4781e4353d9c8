/// Distances to randomly placed points: x to the nearest, y to the second nearest, z their difference, w a random number of the
/// cell. By several ways of measuring.
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale      cells per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 6
/// @param randomness how irregular: 0 is a grid of cubes [0 .. 1] = 1
/// @param metric     0 straight, 1 along the axes, 2 the longest component [0 .. 2] = 0
fn userProc(position: vec4f, scale: f32, randomness: f32, metric: u32) -> vec4f {
    let found = voronoiMetric3D(position.xyz * scale, saturate(randomness), min(metric, 2u));
    let cells = vec4f(found.nearest, found.second, found.second - found.nearest, random1to1(found.id));
    var mean = vec4f(0.53, 0.73, 0.2, 0.5);
    if metric == METRIC_MANHATTAN {
        mean = vec4f(0.77, 1.06, 0.29, 0.5);
    } else if metric >= METRIC_CHEBYSHEV {
        mean = vec4f(0.425, 0.58, 0.155, 0.5);
    }
    return mix(mean, cells, octaveSeen(0.5 * position.w * scale));
}
