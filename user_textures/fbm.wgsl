/// Fractal noise: octaves of gradient noise, each finer and weaker than the one before. The result lies around
/// 0.5, mostly between 0 and 1. Octaves finer than the pixel fade away, so that distant surfaces do not sparkle.
/// @param scale      features per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 4
/// @param octaves    octaves; a fraction is a weaker last octave [1 .. 12] = 5
/// @param lacunarity how much finer each octave is [1.5 .. 4] = 2
/// @param gain       how much weaker each octave is [0 .. 1] = 0.5
/// @param contrast   contrast around 0.5 [0 .. 4] = 1
fn userProc(scale: f32, octaves: f32, lacunarity: f32, gain: f32, contrast: f32) -> f32 {
    let p = readAttr(WorldPos).xyz * scale;
    let pixel = readAttr(Footprint).x * scale;
    return saturate(0.5 + 0.5 * contrast * fbm(p, pixel, clamp(octaves, 1.0, 12.0), lacunarity, gain));
}

// Sum of octaves, about -1 to 1. `pixel` is the width of a pixel in units of p.
fn fbm(p: vec3f, pixel: f32, octaves: f32, lacunarity: f32, gain: f32) -> f32 {
    // Octaves too fine to be seen count as well, or the others would grow as they leave.
    var weight = 0.0;
    var amplitude = 1.0;
    for (var octave = 0; octave < 12; octave++) {
        weight += amplitude * saturate(octaves - f32(octave));
        amplitude *= gain;
    }
    var sum = 0.0;
    amplitude = 1.0;
    var frequency = 1.0;
    for (var octave = 0; octave < 12; octave++) {
        let present = saturate(octaves - f32(octave));
        // A feature that covers less than about two pixels can't be shown.
        let visible = 1.0 - smoothstep(0.3, 0.7, pixel * frequency);
        if present * visible <= 0.0 {
            break; // all further octaves are finer still
        }
        // Each octave is moved, or their lattices would meet in the origin.
        let offset = vec3f(17.3, 5.9, 31.1) * f32(octave);
        sum += amplitude * present * visible * noise(p * frequency + offset);
        amplitude *= gain;
        frequency *= lacunarity;
    }
    return 1.6 * sum / max(weight, 1e-6);
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
