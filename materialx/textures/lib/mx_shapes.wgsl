//! Shapes: 1 inside, 0 outside.

fn circle(p: vec2f, radius: f32) -> f32 {
    return select(1.0, 0.0, dot(p, p) > radius * radius);
}

fn cloverleaf(p: vec2f, radius: f32) -> f32 {
    let q = 2.0 * p;
    let beside = max(circle(q + vec2f(radius, 0.0), radius), circle(q - vec2f(radius, 0.0), radius));
    return max(beside, max(circle(q + vec2f(0.0, radius), radius), circle(q - vec2f(0.0, radius), radius)));
}

// A hexagon whose corners point left and right, by the size of its inner circle: folded along its axes of symmetry until one
// side is left, which lies along x.
fn hexagon(p: vec2f, radius: f32) -> f32 {
    let across = vec2f(-0.866025, 0.5);
    let back = vec2f(0.866025, 0.5);
    var q = abs(p).yx;
    q -= 2.0 * min(dot(across, q), 0.0) * across;
    q -= 2.0 * min(dot(back, q), 0.0) * back;
    q -= vec2f(clamp(q.x, -0.57735 * radius, 0.57735 * radius), radius);
    return select(1.0, 0.0, q.x + q.y > 0.0);
}

fn line(p: vec2f, begin: vec2f, end: vec2f, radius: f32) -> f32 {
    let along = end - begin;
    let way = p - begin;
    let t = saturate(dot(way, along) / max(dot(along, along), 1e-30));
    return select(1.0, 0.0, length(way - t * along) > radius);
}
