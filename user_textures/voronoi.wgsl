/// Random cells (Worley 1996): each point belongs to the nearest of randomly placed centres. Gives four values, to
/// be picked with a swizzle: `.x` distance to the centre of the cell (0 at the centre), `.y` distance from the
/// cell's border (0 on it), `.z` a random number of the cell, `.w` is 1. Distances are in units of a cell.
/// @param scale      cells per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 4
/// @param randomness how irregular: 0 is a grid of cubes [0 .. 1] = 1
fn userProc(scale: f32, randomness: f32) -> vec4f {
    let pixel = readAttr(Footprint).x * scale;
    let cells = voronoi(readAttr(WorldPos).xyz * scale, saturate(randomness));
    // Cells smaller than the pixel fade into their mean, which was measured.
    let fade = smoothstep(0.3, 1.0, pixel);
    let irregular = saturate(randomness) * saturate(randomness);
    let mean = mix(vec3f(0.48, 0.223, 0.5), vec3f(0.52, 0.196, 0.5), irregular);
    return vec4f(mix(cells, mean, fade), 1.0);
}

// Distance to the nearest centre, distance from the border, random number of the cell.
fn voronoi(p: vec3f, randomness: f32) -> vec3f {
    let cell = vec3i(floor(p));
    let f = p - floor(p);
    var nearest = 1e9;
    var second = 1e9;
    var id = 0u;
    for (var z = -1; z <= 1; z++) {
        for (var y = -1; y <= 1; y++) {
            for (var x = -1; x <= 1; x++) {
                let step = vec3i(x, y, z);
                let h = hash(vec3u(cell + step));
                let jitter = vec3f(vec3u(h, h >> 10u, h >> 20u) & vec3u(1023u)) / 1023.0 - 0.5;
                let d = vec3f(step) + 0.5 + randomness * jitter - f;
                let square = dot(d, d);
                if square < nearest {
                    second = nearest;
                    nearest = square;
                    id = h;
                } else {
                    second = min(second, square);
                }
            }
        }
    }
    let distance = sqrt(nearest);
    return vec3f(distance, sqrt(second) - distance, f32(pcg(id) >> 8u) / 16777216.0);
}

fn hash(v: vec3u) -> u32 {
    return pcg(v.x + pcg(v.y + pcg(v.z)));
}

// An integer hash (O'Neill's PCG, RXS-M-XS).
fn pcg(v: u32) -> u32 {
    let state = v * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
