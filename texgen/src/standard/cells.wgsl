
// Standard functions: random cells (Worley 1996). Each point belongs to the nearest of randomly placed centres, one in each unit cube
// or square. `randomness` 0 puts them into the middles, 1 anywhere.

// What is known about the cell at a point: distances to the nearest and second nearest centre, a hash of the cell, and the way to
// both centres.
struct VoronoiCell { nearest: f32, second: f32, id: u32, toNearest: vec3f, toSecond: vec3f }

// Ways of measuring, for the functions with a `metric`: straight, along the axes, the longest component.
const METRIC_EUCLIDEAN = 0u;
const METRIC_MANHATTAN = 1u;
const METRIC_CHEBYSHEV = 2u;

// A length that grows with the distance by the metric; its square for the straight one.
fn metricLength(d: vec3f, metric: u32) -> f32 {
    if metric == METRIC_MANHATTAN {
        return abs(d.x) + abs(d.y) + abs(d.z);
    }
    if metric == METRIC_CHEBYSHEV {
        return max(abs(d.x), max(abs(d.y), abs(d.z)));
    }
    return dot(d, d);
}

// The cells around a point share the hashes of their z, then of their y: `hashU3` and `hashU2` of each, taken apart.

// Where a cube's centre is, in [0, 1] for randomness 1.
fn cellJitter(hash: u32) -> vec3f {
    return vec3f(vec3u(hash, hash >> 10u, hash >> 20u) & vec3u(1023u)) / 1023.0;
}

fn voronoi3D(p: vec3f, randomness: f32) -> VoronoiCell { return voronoiMetric3D(p, randomness, METRIC_EUCLIDEAN); }

fn voronoiMetric3D(p: vec3f, randomness: f32, metric: u32) -> VoronoiCell {
    let q = settled3(p);
    let cell = vec3i(floor(q));
    let f = q - floor(q);
    var found = VoronoiCell(1e9, 1e9, 0u, vec3f(), vec3f());
    for (var z = -1; z <= 1; z++) {
        let layer = hashU1(u32(cell.z + z));
        for (var y = -1; y <= 1; y++) {
            let row = hashU1(u32(cell.y + y) + layer);
            for (var x = -1; x <= 1; x++) {
                let step = vec3i(x, y, z);
                let h = hashU1(u32(cell.x + x) + row);
                let d = vec3f(step) + 0.5 + randomness * (cellJitter(h) - 0.5) - f;
                let length = metricLength(d, metric);
                if length < found.nearest {
                    found = VoronoiCell(length, found.nearest, h, d, found.toNearest);
                } else if length < found.second {
                    found.second = length;
                    found.toSecond = d;
                }
            }
        }
    }
    if metric == METRIC_EUCLIDEAN {
        found.nearest = sqrt(found.nearest);
        found.second = sqrt(found.second);
    }
    return found;
}

// In the plane; z of the ways is 0.
fn voronoi2D(p: vec2f, randomness: f32) -> VoronoiCell { return voronoiMetric2D(p, randomness, METRIC_EUCLIDEAN); }

fn voronoiMetric2D(p: vec2f, randomness: f32, metric: u32) -> VoronoiCell {
    let q = settled2(p);
    let cell = vec2i(floor(q));
    let f = q - floor(q);
    var found = VoronoiCell(1e9, 1e9, 0u, vec3f(), vec3f());
    for (var y = -1; y <= 1; y++) {
        let row = hashU1(u32(cell.y + y));
        for (var x = -1; x <= 1; x++) {
            let step = vec2i(x, y);
            let h = hashU1(u32(cell.x + x) + row);
            let jitter = vec2f(vec2u(h, h >> 16u) & vec2u(65535u)) / 65535.0 - 0.5;
            let d = vec3f(vec2f(step) + 0.5 + randomness * jitter - f, 0.0);
            let length = metricLength(d, metric);
            if length < found.nearest {
                found = VoronoiCell(length, found.nearest, h, d, found.toNearest);
            } else if length < found.second {
                found.second = length;
                found.toSecond = d;
            }
        }
    }
    if metric == METRIC_EUCLIDEAN {
        found.nearest = sqrt(found.nearest);
        found.second = sqrt(found.second);
    }
    return found;
}

// Distance to the cell's border (Quilez 2012): 0 on it. Nearly exact: a cell that lies two away is rarely the neighbour, and missed then.
fn voronoiEdge3D(p: vec3f, randomness: f32) -> f32 {
    let q = settled3(p);
    let cell = vec3i(floor(q));
    let f = q - floor(q);
    let own = voronoi3D(q, randomness).toNearest;
    var edge = 1e9;
    for (var z = -1; z <= 1; z++) {
        let layer = hashU1(u32(cell.z + z));
        for (var y = -1; y <= 1; y++) {
            let row = hashU1(u32(cell.y + y) + layer);
            for (var x = -1; x <= 1; x++) {
                let step = vec3i(x, y, z);
                let d = vec3f(step) + 0.5 + randomness * (cellJitter(hashU1(u32(cell.x + x) + row)) - 0.5) - f;
                let across = d - own;
                let length = length(across);
                if length > 1e-4 {
                    edge = min(edge, dot(0.5 * (own + d), across / length));
                }
            }
        }
    }
    return edge;
}

fn voronoiEdge2D(p: vec2f, randomness: f32) -> f32 {
    let q = settled2(p);
    let cell = vec2i(floor(q));
    let f = q - floor(q);
    let own = voronoi2D(q, randomness).toNearest.xy;
    var edge = 1e9;
    for (var y = -2; y <= 2; y++) {
        let row = hashU1(u32(cell.y + y));
        for (var x = -2; x <= 2; x++) {
            let step = vec2i(x, y);
            let h = hashU1(u32(cell.x + x) + row);
            let jitter = vec2f(vec2u(h, h >> 16u) & vec2u(65535u)) / 65535.0 - 0.5;
            let d = vec2f(step) + 0.5 + randomness * jitter - f;
            let across = d - own;
            let length = length(across);
            if length > 1e-4 {
                edge = min(edge, dot(0.5 * (own + d), across / length));
            }
        }
    }
    return edge;
}

// Distance to the nearest centre without creases: `smoothness` (0 to 1) is how wide cells run into each other.
fn voronoiSmooth3D(p: vec3f, randomness: f32, smoothness: f32) -> f32 {
    let q = settled3(p);
    let cell = vec3i(floor(q));
    let f = q - floor(q);
    let width = max(smoothness, 1e-3);
    // Farther centres matter no more. Within `width` of the nearest they do, and up to twice that by those between: which makes them
    // lie two cells away at times.
    let limit = voronoi3D(q, randomness).nearest + 2.0 * width;
    var smallest = 8.0;
    for (var z = -2; z <= 2; z++) {
        let layer = hashU1(u32(cell.z + z));
        for (var y = -2; y <= 2; y++) {
            let row = hashU1(u32(cell.y + y) + layer);
            for (var x = -2; x <= 2; x++) {
                let step = vec3i(x, y, z);
                let gap = max(abs(vec3f(step) + 0.5 - f) - 0.5 * randomness, vec3f());
                if dot(gap, gap) < limit * limit {
                    let d = vec3f(step) + 0.5 + randomness * (cellJitter(hashU1(u32(cell.x + x) + row)) - 0.5) - f;
                    let distance = length(d);
                    let h = smoothstep(0.0, 1.0, 0.5 + 0.5 * (smallest - distance) / width);
                    smallest = mix(smallest, distance, h) - 0.25 * width * h * (1.0 - h);
                }
            }
        }
    }
    return max(smallest, 0.0);
}
