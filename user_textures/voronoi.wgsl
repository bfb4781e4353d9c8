struct Voronoi {
    cells: vec4f,
    distance: f32,
    border: f32,
    cell: f32,
    color: vec3f,
}

/// Random cells (Worley 1996): each point belongs to the nearest of randomly placed centres. What it gives is taken by name, as in
/// `cells.color`, all of it from one evaluation. Distances are in units of a cell.
/// @output cells    distance, border and cell as components: `.x`, `.y`, `.z`; `.w` is 1
/// @output distance to the centre of the cell: 0 at the centre
/// @output border   distance from the cell's border: 0 on it
/// @output cell     a random number of the cell
/// @output color    a random colour of the cell
/// @param scale      cells per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 4
/// @param randomness how irregular: 0 is a grid of cubes [0 .. 1] = 1
/// @group noise
/// @param position where; link `mapping` or `warp` to change it [attr WorldPos]
fn userProc(scale: f32, randomness: f32, position: vec4f) -> Voronoi {
    let pixel = position.w * scale;
    let found = voronoi3D(position.xyz * scale, saturate(randomness));
    let cells = vec3f(found.nearest, found.second - found.nearest, random1to1(found.id));
    // Cells smaller than the pixel fade into their mean, which was measured.
    let fade = smoothstep(0.3, 1.0, pixel);
    let irregular = saturate(randomness) * saturate(randomness);
    let mean = mix(vec3f(0.48, 0.223, 0.5), vec3f(0.52, 0.196, 0.5), irregular);
    let seen = mix(cells, mean, fade);
    let color = mix(random1to3(found.id), vec3f(0.5), fade);
    return Voronoi(vec4f(seen, 1.0), seen.x, seen.y, seen.z, color);
}
