
// Standard functions: noise. Each repeats only after 2^32 cells of size 1; the mean is 0. Those called ...Grad give the value and,
// behind it, its derivatives.

// What a value becomes between the corners of a cell, and its derivative: smooth up to the second derivative.
fn noiseFade(f: vec4f) -> vec4f { return f * f * f * (f * (f * 6.0 - 15.0) + 10.0); }
fn noiseFadeSlope(f: vec4f) -> vec4f { return 30.0 * f * f * (f * (f - 2.0) + 1.0); }

// Value noise: random numbers at the corners of cells, smoothly mixed; -1 to 1.
fn valueNoise2D(p: vec2f) -> f32 {
    let cell = floor(p);
    let f = p - cell;
    let i = vec2u(vec2i(cell));
    let u = f * f * (3.0 - 2.0 * f);
    let y0 = hashU1(i.y);
    let y1 = hashU1(i.y + 1u);
    let low = mix(valueCorner(i.x + y0), valueCorner(i.x + 1u + y0), u.x);
    let high = mix(valueCorner(i.x + y1), valueCorner(i.x + 1u + y1), u.x);
    return mix(low, high, u.y);
}
fn valueNoise3D(p: vec3f) -> f32 { return valueNoise3DGrad(p).x; }
fn valueNoise4D(p: vec4f) -> f32 { return valueNoise4DGrad(p).value; }

fn valueCorner(v: u32) -> f32 { return f32(hashU1(v) >> 8u) / 8388608.0 - 1.0; }

fn valueNoise2DGrad(p: vec2f) -> vec3f {
    let cell = floor(p);
    let f = p - cell;
    let i = vec2u(vec2i(cell));
    let u = f * f * (3.0 - 2.0 * f);
    let du = 6.0 * f * (1.0 - f);
    let y0 = hashU1(i.y);
    let y1 = hashU1(i.y + 1u);
    let a = valueCorner(i.x + y0);
    let b = valueCorner(i.x + 1u + y0);
    let c = valueCorner(i.x + y1);
    let d = valueCorner(i.x + 1u + y1);
    let k = a - b - c + d;
    let value = a + (b - a) * u.x + (c - a) * u.y + k * u.x * u.y;
    return vec3f(value, du * (vec2f(b - a, c - a) + k * u.yx));
}

fn valueNoise3DGrad(p: vec3f) -> vec4f {
    let cell = floor(p);
    let f = p - cell;
    let i = vec3u(vec3i(cell));
    let u = f * f * (3.0 - 2.0 * f);
    let du = 6.0 * f * (1.0 - f);
    let z0 = hashU1(i.z);
    let z1 = hashU1(i.z + 1u);
    let low = valueFace(i.xy, z0, u.xy, du.xy);
    let high = valueFace(i.xy, z1, u.xy, du.xy);
    return vec4f(mix(low, high, u.z), du.z * (high.x - low.x));
}

// Value and derivatives by x and y on a face of a cell.
fn valueFace(i: vec2u, z: u32, u: vec2f, du: vec2f) -> vec3f {
    let y0 = hashU1(i.y + z);
    let y1 = hashU1(i.y + 1u + z);
    let a = valueCorner(i.x + y0);
    let b = valueCorner(i.x + 1u + y0);
    let c = valueCorner(i.x + y1);
    let d = valueCorner(i.x + 1u + y1);
    let k = a - b - c + d;
    let value = a + (b - a) * u.x + (c - a) * u.y + k * u.x * u.y;
    return vec3f(value, du * (vec2f(b - a, c - a) + k * u.yx));
}

// A value in four dimensions with its derivatives.
struct NoiseGrad4 { value: f32, gradient: vec4f }

fn valueNoise4DGrad(p: vec4f) -> NoiseGrad4 {
    let cell = floor(p);
    let f = p - cell;
    let i = vec4u(vec4i(cell));
    let u = f * f * (3.0 - 2.0 * f);
    let du = 6.0 * f * (1.0 - f);
    let low = valueSolid(i.xyz, hashU1(i.w), u.xyz, du.xyz);
    let high = valueSolid(i.xyz, hashU1(i.w + 1u), u.xyz, du.xyz);
    let all = mix(low, high, u.w);
    return NoiseGrad4(all.x, vec4f(all.yzw, du.w * (high.x - low.x)));
}

fn valueSolid(i: vec3u, w: u32, u: vec3f, du: vec3f) -> vec4f {
    let low = valueFace(i.xy, hashU1(i.z + w), u.xy, du.xy);
    let high = valueFace(i.xy, hashU1(i.z + 1u + w), u.xy, du.xy);
    return vec4f(mix(low, high, u.z), du.z * (high.x - low.x));
}

// Gradient noise (Perlin 2002) with hashed gradients; about -0.9 to 0.9, 0 at the corners of the cells.
fn perlin2D(p: vec2f) -> f32 { return perlin2DGrad(p).x; }
fn perlin3D(p: vec3f) -> f32 {
    let cell = floor(p);
    let f = p - cell;
    let i = vec3u(vec3i(cell));
    let u = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    // Corners share the hashes of their z, then of their y.
    let z0 = hashU1(i.z);
    let z1 = hashU1(i.z + 1u);
    let y00 = hashU1(i.y + z0);
    let y10 = hashU1(i.y + 1u + z0);
    let y01 = hashU1(i.y + z1);
    let y11 = hashU1(i.y + 1u + z1);
    let x00 = mix(perlinSlope3D(i.x + y00, f), perlinSlope3D(i.x + 1u + y00, f - vec3f(1.0, 0.0, 0.0)), u.x);
    let x10 = mix(perlinSlope3D(i.x + y10, f - vec3f(0.0, 1.0, 0.0)), perlinSlope3D(i.x + 1u + y10, f - vec3f(1.0, 1.0, 0.0)), u.x);
    let x01 = mix(perlinSlope3D(i.x + y01, f - vec3f(0.0, 0.0, 1.0)), perlinSlope3D(i.x + 1u + y01, f - vec3f(1.0, 0.0, 1.0)), u.x);
    let x11 = mix(perlinSlope3D(i.x + y11, f - vec3f(0.0, 1.0, 1.0)), perlinSlope3D(i.x + 1u + y11, f - vec3f(1.0, 1.0, 1.0)), u.x);
    return mix(mix(x00, x10, u.y), mix(x01, x11, u.y), u.z);
}
fn perlin4D(p: vec4f) -> f32 { return perlin4DGrad(p).value; }

// Height at offset d of a plane through the corner with a random slope.
fn perlinSlope3D(corner: u32, d: vec3f) -> f32 { return dot(noiseGradient3(hashU1(corner)), d); }

// Random slopes, components in [-1, 1].
fn noiseGradient2(hash: u32) -> vec2f {
    return vec2f(vec2u(hash, hash >> 16u) & vec2u(65535u)) * (2.0 / 65535.0) - 1.0;
}
fn noiseGradient3(hash: u32) -> vec3f {
    return vec3f(vec3u(hash, hash >> 10u, hash >> 20u) & vec3u(1023u)) * (2.0 / 1023.0) - 1.0;
}
fn noiseGradient4(hash: u32) -> vec4f {
    return vec4f(vec4u(hash, hash >> 8u, hash >> 16u, hash >> 24u) & vec4u(255u)) * (2.0 / 255.0) - 1.0;
}

fn perlin2DGrad(p: vec2f) -> vec3f {
    let cell = floor(p);
    let f = p - cell;
    let i = vec2u(vec2i(cell));
    let u = noiseFade(f.xyxy).xy;
    let du = noiseFadeSlope(f.xyxy).xy;
    let y0 = hashU1(i.y);
    let y1 = hashU1(i.y + 1u);
    let ga = noiseGradient2(hashU1(i.x + y0));
    let gb = noiseGradient2(hashU1(i.x + 1u + y0));
    let gc = noiseGradient2(hashU1(i.x + y1));
    let gd = noiseGradient2(hashU1(i.x + 1u + y1));
    let a = dot(ga, f);
    let b = dot(gb, f - vec2f(1.0, 0.0));
    let c = dot(gc, f - vec2f(0.0, 1.0));
    let d = dot(gd, f - vec2f(1.0, 1.0));
    let value = mix(mix(a, b, u.x), mix(c, d, u.x), u.y);
    let slope = mix(mix(ga, gb, u.x), mix(gc, gd, u.x), u.y);
    return vec3f(value, slope + du * vec2f(mix(b - a, d - c, u.y), mix(c - a, d - b, u.x)));
}

fn perlin3DGrad(p: vec3f) -> vec4f {
    let cell = floor(p);
    let f = p - cell;
    let u = noiseFade(f.xyzx).xyz;
    let du = noiseFadeSlope(f.xyzx).xyz;
    let i = vec3u(vec3i(cell));
    let low = perlinFace(i.xy, hashU1(i.z), f, u.xy, du.xy);
    let high = perlinFace(i.xy, hashU1(i.z + 1u), f - vec3f(0.0, 0.0, 1.0), u.xy, du.xy);
    return mix(low, high, u.z) + vec4f(0.0, 0.0, 0.0, du.z * (high.x - low.x));
}

// Value and derivatives of the four corners with one z.
fn perlinFace(i: vec2u, z: u32, f: vec3f, u: vec2f, du: vec2f) -> vec4f {
    let y0 = hashU1(i.y + z);
    let y1 = hashU1(i.y + 1u + z);
    let ga = noiseGradient3(hashU1(i.x + y0));
    let gb = noiseGradient3(hashU1(i.x + 1u + y0));
    let gc = noiseGradient3(hashU1(i.x + y1));
    let gd = noiseGradient3(hashU1(i.x + 1u + y1));
    let a = dot(ga, f);
    let b = dot(gb, f - vec3f(1.0, 0.0, 0.0));
    let c = dot(gc, f - vec3f(0.0, 1.0, 0.0));
    let d = dot(gd, f - vec3f(1.0, 1.0, 0.0));
    let value = mix(mix(a, b, u.x), mix(c, d, u.x), u.y);
    let slope = mix(mix(ga, gb, u.x), mix(gc, gd, u.x), u.y);
    let turn = du * vec2f(mix(b - a, d - c, u.y), mix(c - a, d - b, u.x));
    return vec4f(value, slope + vec3f(turn, 0.0));
}

fn perlin4DGrad(p: vec4f) -> NoiseGrad4 {
    let cell = floor(p);
    let f = p - cell;
    let u = noiseFade(f);
    let du = noiseFadeSlope(f);
    let i = vec4u(vec4i(cell));
    let low = perlinSolid(i.xyz, hashU1(i.w), f, u.xyz, du.xyz);
    let high = perlinSolid(i.xyz, hashU1(i.w + 1u), f - vec4f(0.0, 0.0, 0.0, 1.0), u.xyz, du.xyz);
    let gradient = mix(low.gradient, high.gradient, u.w) + vec4f(0.0, 0.0, 0.0, du.w * (high.value - low.value));
    return NoiseGrad4(mix(low.value, high.value, u.w), gradient);
}

// The eight corners with one w.
fn perlinSolid(i: vec3u, w: u32, f: vec4f, u: vec3f, du: vec3f) -> NoiseGrad4 {
    let low = perlinSquare(i.xy, hashU1(i.z + w), f, u.xy, du.xy);
    let high = perlinSquare(i.xy, hashU1(i.z + 1u + w), f - vec4f(0.0, 0.0, 1.0, 0.0), u.xy, du.xy);
    let gradient = mix(low.gradient, high.gradient, u.z) + vec4f(0.0, 0.0, du.z * (high.value - low.value), 0.0);
    return NoiseGrad4(mix(low.value, high.value, u.z), gradient);
}

fn perlinSquare(i: vec2u, z: u32, f: vec4f, u: vec2f, du: vec2f) -> NoiseGrad4 {
    let y0 = hashU1(i.y + z);
    let y1 = hashU1(i.y + 1u + z);
    let ga = noiseGradient4(hashU1(i.x + y0));
    let gb = noiseGradient4(hashU1(i.x + 1u + y0));
    let gc = noiseGradient4(hashU1(i.x + y1));
    let gd = noiseGradient4(hashU1(i.x + 1u + y1));
    let a = dot(ga, f);
    let b = dot(gb, f - vec4f(1.0, 0.0, 0.0, 0.0));
    let c = dot(gc, f - vec4f(0.0, 1.0, 0.0, 0.0));
    let d = dot(gd, f - vec4f(1.0, 1.0, 0.0, 0.0));
    let value = mix(mix(a, b, u.x), mix(c, d, u.x), u.y);
    let slope = mix(mix(ga, gb, u.x), mix(gc, gd, u.x), u.y);
    let turn = du * vec2f(mix(b - a, d - c, u.y), mix(c - a, d - b, u.x));
    return NoiseGrad4(value, slope + vec4f(turn, 0.0, 0.0));
}

// Simplex noise (Perlin 2001): cells are simplices, so no direction stands out; about -1 to 1.
fn simplex2D(p: vec2f) -> f32 { return simplex2DGrad(p).x; }
fn simplex3D(p: vec3f) -> f32 { return simplex3DGrad(p).x; }
fn simplex4D(p: vec4f) -> f32 { return simplex4DGrad(p).value; }

fn simplex2DGrad(p: vec2f) -> vec3f {
    let cell = floor(p + (p.x + p.y) * 0.3660254);
    let a = p - cell + (cell.x + cell.y) * 0.21132487;
    let step = select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), a.x > a.y);
    let i = vec2u(vec2i(cell));
    let sum = simplexCorner2(hashU2(i), a)
        + simplexCorner2(hashU2(i + vec2u(step)), a - step + 0.21132487)
        + simplexCorner2(hashU2(i + 1u), a - 1.0 + 0.42264973);
    return 85.0 * sum;
}

// What a corner at offset -d adds: value, derivatives.
fn simplexCorner2(hash: u32, d: vec2f) -> vec3f {
    let t = max(0.5 - dot(d, d), 0.0);
    let g = noiseGradient2(hash);
    let height = dot(g, d);
    return t * t * t * vec3f(t * height, t * g - 8.0 * height * d);
}

fn simplex3DGrad(p: vec3f) -> vec4f {
    let cell = floor(p + (p.x + p.y + p.z) / 3.0);
    let a = p - cell + (cell.x + cell.y + cell.z) / 6.0;
    // The order of the components says which simplex of the cube it is.
    let above = step(a.yzx, a.xyz);
    let below = 1.0 - above;
    let first = min(above.xyz, below.zxy);
    let second = max(above.xyz, below.zxy);
    let i = vec3u(vec3i(cell));
    let sum = simplexCorner3(hashU3(i), a)
        + simplexCorner3(hashU3(i + vec3u(first)), a - first + 1.0 / 6.0)
        + simplexCorner3(hashU3(i + vec3u(second)), a - second + 1.0 / 3.0)
        + simplexCorner3(hashU3(i + 1u), a - 0.5);
    return 75.0 * sum;
}

fn simplexCorner3(hash: u32, d: vec3f) -> vec4f {
    let t = max(0.5 - dot(d, d), 0.0);
    let g = noiseGradient3(hash);
    let height = dot(g, d);
    return t * t * t * vec4f(t * height, t * g - 8.0 * height * d);
}

fn simplex4DGrad(p: vec4f) -> NoiseGrad4 {
    let cell = floor(p + dot(p, vec4f(0.309017)));
    let a = p - cell + dot(cell, vec4f(0.1381966));
    // Rank of each component among the four.
    let xy = step(a.yzw, a.xxx);
    let zw = step(vec3f(a.z, a.w, a.w), vec3f(a.y, a.y, a.z));
    let rank = vec4f(
        xy.x + xy.y + xy.z,
        1.0 - xy.x + zw.x + zw.y,
        2.0 - xy.y - zw.x + zw.z,
        3.0 - xy.z - zw.y - zw.z,
    );
    let first = saturate(rank - 2.0);
    let second = saturate(rank - 1.0);
    let third = saturate(rank);
    let i = vec4u(vec4i(cell));
    var sum = NoiseGrad4(0.0, vec4f());
    sum = simplexCorner4(sum, hashU4(i), a);
    sum = simplexCorner4(sum, hashU4(i + vec4u(first)), a - first + 0.1381966);
    sum = simplexCorner4(sum, hashU4(i + vec4u(second)), a - second + 0.2763932);
    sum = simplexCorner4(sum, hashU4(i + vec4u(third)), a - third + 0.4145898);
    sum = simplexCorner4(sum, hashU4(i + 1u), a - 0.4472136);
    return NoiseGrad4(70.0 * sum.value, 70.0 * sum.gradient);
}

fn simplexCorner4(before: NoiseGrad4, hash: u32, d: vec4f) -> NoiseGrad4 {
    let t = max(0.5 - dot(d, d), 0.0);
    let g = noiseGradient4(hash);
    let height = dot(g, d);
    let cubed = t * t * t;
    return NoiseGrad4(before.value + cubed * t * height, before.gradient + cubed * (t * g - 8.0 * height * d));
}

// Gabor noise (Lagae et al. 2009): waves of one frequency, in cycles per cell. `angle` is their direction in radians, and
// `spread` how far the directions differ: 0 all run the same way, 1 they run anywhere. About -1 to 1.
fn gabor2D(p: vec2f, frequency: f32, angle: f32, spread: f32) -> f32 {
    let q = settled2(p);
    let cell = floor(q);
    let f = q - cell;
    var sum = 0.0;
    for (var k = 0; k < 9; k++) {
        let step = vec2f(f32(k % 3), f32(k / 3)) - 1.0;
        let seed = hashU2(vec2u(vec2i(cell + step)));
        for (var n = 0u; n < 4u; n++) {
            let r = random3of(seed + 7919u * n);
            let d = f - step - r.xy;
            let square = dot(d, d);
            if square < 1.0 {
                let turn = angle + spread * 3.1415927 * (unitFloat(hashU1(seed + 31u * n)) - 0.5);
                let wave = cos(6.2831853 * (frequency * (d.x * cos(turn) + d.y * sin(turn)) + r.z));
                sum += (1.0 - square) * (1.0 - square) * exp(-2.0 * square) * wave;
            }
        }
    }
    return 0.5 * sum;
}

// The same in three dimensions, along `axis` (unit length).
fn gabor3D(p: vec3f, frequency: f32, axis: vec3f, spread: f32) -> f32 {
    let q = settled3(p);
    let cell = floor(q);
    let f = q - cell;
    var sum = 0.0;
    for (var k = 0; k < 27; k++) {
        let step = vec3f(f32(k % 3), f32(k / 3 % 3), f32(k / 9)) - 1.0;
        let seed = hashU3(vec3u(vec3i(cell + step)));
        for (var n = 0u; n < 2u; n++) {
            let d = f - step - random3of(seed + 7919u * n);
            let square = dot(d, d);
            if square < 1.0 {
                let turn = axis + 3.0 * spread * (random3of(seed + 31u * n + 5u) - 0.5);
                let direction = turn / max(length(turn), 1e-4);
                let phase = unitFloat(hashU1(seed + 127u * n));
                let wave = cos(6.2831853 * (frequency * dot(d, direction) + phase));
                sum += (1.0 - square) * (1.0 - square) * exp(-2.0 * square) * wave;
            }
        }
    }
    return 0.6 * sum;
}
