/// Random cells (Worley 1996): each point belongs to the nearest of randomly placed centres. Gives four values, to
/// be picked with a swizzle: `.x` distance to the centre of the cell (0 at the centre), `.y` distance from the
/// cell's border (0 on it), `.z` a random number of the cell, `.w` is 1. Distances are in units of a cell.
/// @param scale      cells per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 4
/// @param randomness how irregular: 0 is a grid of cubes [0 .. 1] = 1
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr WorldPos]
fn userProc(scale: f32, randomness: f32, position: vec4f) -> vec4f {
    let pixel = position.w * scale;
    let found = voronoi3D(position.xyz * scale, saturate(randomness));
    let cells = vec3f(found.nearest, found.second - found.nearest, random1to1(found.id));
    // Cells smaller than the pixel fade into their mean, which was measured.
    let fade = smoothstep(0.3, 1.0, pixel);
    let irregular = saturate(randomness) * saturate(randomness);
    let mean = mix(vec3f(0.48, 0.223, 0.5), vec3f(0.52, 0.196, 0.5), irregular);
    return vec4f(mix(cells, mean, fade), 1.0);
}
