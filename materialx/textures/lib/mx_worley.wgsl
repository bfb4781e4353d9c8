//! Distances to randomly placed points, one in each cell, as MaterialX defines them.
//! @use mx_jenkins

// The three least distances so far, with one more.
fn sorted(least: vec3f, distance: f32) -> vec3f {
    if distance < least.x {
        return vec3f(distance, least.xy);
    }
    if distance < least.y {
        return vec3f(least.x, distance, least.y);
    }
    return vec3f(least.xy, min(least.z, distance));
}

struct Near2 {
    distances: vec3f, // squared
    cell: vec2f,      // a place in the cell of the nearest point: the point itself
}

fn nearest2(p: vec2f, jitter: f32) -> Near2 {
    let cell = vec2i(floor(p));
    let f = p - floor(p);
    var near = Near2(vec3f(1e6), vec2f());
    for (var x = -1; x <= 1; x++) {
        for (var y = -1; y <= 1; y++) {
            let offset = (cellOf3_2(cell + vec2i(x, y)).xy - 0.5) * jitter + 0.5;
            let way = vec2f(f32(x), f32(y)) + offset - f;
            let distance = dot(way, way);
            if distance < near.distances.x {
                near.cell = way + p;
            }
            near.distances = sorted(near.distances, distance);
        }
    }
    return near;
}

struct Near3 {
    distances: vec3f,
    cell: vec3f,
}

fn nearest3(p: vec3f, jitter: f32) -> Near3 {
    let cell = vec3i(floor(p));
    let f = p - floor(p);
    var near = Near3(vec3f(1e6), vec3f());
    for (var x = -1; x <= 1; x++) {
        for (var y = -1; y <= 1; y++) {
            for (var z = -1; z <= 1; z++) {
                let offset = (cellOf3_3(cell + vec3i(x, y, z)) - 0.5) * jitter + 0.5;
                let way = vec3f(f32(x), f32(y), f32(z)) + offset - f;
                let distance = dot(way, way);
                if distance < near.distances.x {
                    near.cell = way + p;
                }
                near.distances = sorted(near.distances, distance);
            }
        }
    }
    return near;
}

// Distances to the three nearest points, or three random numbers of the nearest one's cell.
fn worley2(p: vec2f, jitter: f32, is_solid: bool) -> vec3f {
    let near = nearest2(p, jitter);
    if is_solid {
        return cellOf3_2(vec2i(floor(near.cell)));
    }
    return sqrt(near.distances);
}

fn worley3(p: vec3f, jitter: f32, is_solid: bool) -> vec3f {
    let near = nearest3(p, jitter);
    if is_solid {
        return cellOf3_3(vec3i(floor(near.cell)));
    }
    return sqrt(near.distances);
}

// Distance to the nearest point, or one random number of its cell: another one than the first of three.
fn worleyOf1_2(p: vec2f, jitter: f32, is_solid: bool) -> f32 {
    let near = nearest2(p, jitter);
    if is_solid {
        return cell2(near.cell);
    }
    return sqrt(near.distances.x);
}

fn worleyOf1_3(p: vec3f, jitter: f32, is_solid: bool) -> f32 {
    let near = nearest3(p, jitter);
    if is_solid {
        return cell3(near.cell);
    }
    return sqrt(near.distances.x);
}
