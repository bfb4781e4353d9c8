/// The colour of rust. Broad stains, blistered flakes and fine grain are added up to one number, and the ramp gives
/// it its colour: old, dark scale at 0, fresh orange rust at 1.
/// @param scale  stains per metre [0.01 .. 1000] [soft 1 .. 100] [log] = 12
/// @param ramp   colours from old to fresh rust [smooth] = [(0.0, #170d09), (0.28, #3a1a0e), (0.5, #6b3213), (0.75, #9c4d1d), (1.0, #c98a4b)]
/// @param grain  strength of the fine grain [0 .. 1] [percent] = 0.5
/// @param flakes strength of the flakes [0 .. 1] [percent] = 0.5
fn userProc(scale: f32, ramp: ramp1D, grain: f32, flakes: f32) -> vec3f {
    let p = readAttr(WorldPos).xyz * scale;
    let pixel = readAttr(Footprint).x * scale;
    // Stains run into each other: the noise is warped by another one.
    let warp = vec3f(noise(p * 0.7), noise(p * 0.7 + 19.1), noise(p * 0.7 + 47.3));
    let stains = fbm(p + 0.9 * warp, pixel, 6);
    let speckles = fbm(p * 9.0 + 0.5 * warp, pixel * 9.0, 4);
    // Flakes have ragged edges, and lie in some places only.
    let ragged = vec3f(speckles, noise(p * 7.0 + 3.3), noise(p * 7.0 + 8.1));
    let flake = flake_field(p * 1.7 + 0.6 * warp + 0.16 * ragged);
    let blistered = smoothstep(-0.1, 0.5, noise(p * 0.45 + 71.0) + 0.4 * stains) * (1.0 - smoothstep(0.15, 0.5, pixel));
    let lift = flakes * blistered * (0.5 * (flake.y - 0.5) + 0.35 * (smoothstep(0.0, 0.3, flake.x) - 0.6));
    let t = 0.5 + 0.42 * stains + lift + 0.4 * grain * speckles;
    // Pits are deeper than the ramp can say: nearly no light comes back.
    let pits = smoothstep(0.35, 0.75, speckles) * grain;
    // What is too fine to be seen spreads t over the pixel: the deviations of stains, speckles and flakes.
    let spread = smoothstep(vec2f(0.3), vec2f(0.7), vec2f(pixel, pixel * 9.0)) * vec2f(0.076, 0.072 * grain);
    let blisters = 0.06 * flakes * smoothstep(0.15, 0.5, pixel);
    let color = ramp_mean(ramp, t, length(vec3f(spread, blisters)));
    return color * (1.0 - 0.6 * pits);
}

// Mean of the ramp over a bell curve around t (Gauss-Hermite quadrature with three points).
fn ramp_mean(ramp: ramp1D, t: f32, deviation: f32) -> vec3f {
    let middle = rampEval(ramp, saturate(t)).rgb;
    if deviation <= 0.0 {
        return middle;
    }
    let away = 1.7320508 * deviation;
    return (4.0 * middle + rampEval(ramp, saturate(t - away)).rgb + rampEval(ramp, saturate(t + away)).rgb) / 6.0;
}

// Random cells: distance from the border of the cell, random number of the cell.
fn flake_field(p: vec3f) -> vec2f {
    let cell = vec3i(floor(p));
    let f = p - floor(p);
    var nearest = 1e9;
    var second = 1e9;
    var id = 0u;
    for (var z = -1; z <= 1; z++) {
        for (var y = -1; y <= 1; y++) {
            for (var x = -1; x <= 1; x++) {
                let step = vec3i(x, y, z);
                let at = vec3u(cell + step);
                let h = pcg(at.x + pcg(at.y + pcg(at.z)));
                let d = vec3f(step) + vec3f(vec3u(h, h >> 10u, h >> 20u) & vec3u(1023u)) / 1023.0 - f;
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
    return vec2f(sqrt(second) - sqrt(nearest), f32(pcg(id) >> 8u) / 16777216.0);
}

// Octaves of gradient noise, about -1 to 1; those finer than the pixel fade away.
fn fbm(p: vec3f, pixel: f32, octaves: i32) -> f32 {
    var sum = 0.0;
    var amplitude = 0.5;
    var frequency = 1.0;
    for (var octave = 0; octave < octaves; octave++) {
        let visible = 1.0 - smoothstep(0.3, 0.7, pixel * frequency);
        if visible <= 0.0 {
            break;
        }
        sum += amplitude * visible * noise(p * frequency + vec3f(17.3, 5.9, 31.1) * f32(octave));
        amplitude *= 0.55;
        frequency *= 2.03;
    }
    return 1.7 * sum;
}

// Gradient noise (Perlin 2002) with hashed gradients; about -0.9 to 0.9.
fn noise(p: vec3f) -> f32 {
    let cell = floor(p);
    let f = p - cell;
    let i = vec3u(vec3i(cell));
    let u = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    // Corners share the hashes of their z, then of their y.
    let z0 = pcg(i.z);
    let z1 = pcg(i.z + 1u);
    let y00 = pcg(i.y + z0);
    let y10 = pcg(i.y + 1u + z0);
    let y01 = pcg(i.y + z1);
    let y11 = pcg(i.y + 1u + z1);
    let x00 = mix(slope(i.x + y00, f), slope(i.x + 1u + y00, f - vec3f(1.0, 0.0, 0.0)), u.x);
    let x10 = mix(slope(i.x + y10, f - vec3f(0.0, 1.0, 0.0)), slope(i.x + 1u + y10, f - vec3f(1.0, 1.0, 0.0)), u.x);
    let x01 = mix(slope(i.x + y01, f - vec3f(0.0, 0.0, 1.0)), slope(i.x + 1u + y01, f - vec3f(1.0, 0.0, 1.0)), u.x);
    let x11 = mix(slope(i.x + y11, f - vec3f(0.0, 1.0, 1.0)), slope(i.x + 1u + y11, f - vec3f(1.0, 1.0, 1.0)), u.x);
    return mix(mix(x00, x10, u.y), mix(x01, x11, u.y), u.z);
}

// Height at offset d of a plane through the corner with a random gradient.
fn slope(corner: u32, d: vec3f) -> f32 {
    let h = pcg(corner);
    let gradient = vec3f(vec3u(h, h >> 10u, h >> 20u) & vec3u(1023u)) * (2.0 / 1023.0) - 1.0;
    return dot(gradient, d);
}

// An integer hash (O'Neill's PCG, RXS-M-XS).
fn pcg(v: u32) -> u32 {
    let state = v * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
