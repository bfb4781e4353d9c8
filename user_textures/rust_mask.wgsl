/// Where metal rusts: 0 is clean, 1 is rust. Rust comes in noisy patches and grows in crevices, where water stays:
/// there ambient occlusion is strong. The node's `occlusion` names the AO slot; its distance is how far rust
/// creeps out of a crevice.
/// @param scale     patches per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 4
/// @param amount    how much of an open surface rusts [0 .. 1] [percent] = 0.3
/// @param influence how strongly crevices attract rust [0 .. 4] = 1.5
/// @param contrast  hardness of the edges: 0 is soft [0 .. 1] = 0.7
fn userProc(scale: f32, amount: f32, influence: f32, contrast: f32) -> f32 {
    let p = readAttr(WorldPos).xyz * scale;
    let pixel = readAttr(Footprint).x * scale;
    // Patches, with edges that fray: the coarse noise is pushed about by a finer one.
    let fray = vec3f(noise(p * 2.7), noise(p * 2.7 + 11.3), noise(p * 2.7 + 23.9));
    let noise_and_lost = fbm(p + 0.25 * fray, pixel);
    let patches = noise_and_lost.x;
    // Rust begins in crevices and, with time, runs out of them: the noise decides how far.
    let occluded = 1.0 - readAttr(AO).x;
    let crevice = influence * occluded * (0.6 + 0.6 * patches);
    // The noise is spread about 0 like a bell: the logistic threshold makes `amount` the area that rusts.
    let covered = clamp(amount, 0.0005, 0.9995);
    let threshold = 0.13 * log((1.0 - covered) / covered);
    // Patches too small to be seen leave a soft threshold behind: their mean.
    let softness = 0.015 + 0.3 * (1.0 - saturate(contrast)) + 0.3 * noise_and_lost.y;
    return smoothstep(threshold - softness, threshold + softness, patches + crevice);
}

// x: six octaves of gradient noise, about -1 to 1; those finer than the pixel fade away. y: how much has faded, 0 to 1.
fn fbm(p: vec3f, pixel: f32) -> vec2f {
    var sum = 0.0;
    var seen = 0.0;
    var amplitude = 0.5;
    var frequency = 1.0;
    for (var octave = 0; octave < 6; octave++) {
        let visible = 1.0 - smoothstep(0.3, 0.7, pixel * frequency);
        if visible <= 0.0 {
            break;
        }
        sum += amplitude * visible * noise(p * frequency + vec3f(17.3, 5.9, 31.1) * f32(octave));
        seen += amplitude * visible;
        amplitude *= 0.55;
        frequency *= 2.03;
    }
    let all = 0.5 * (1.0 - pow(0.55, 6.0)) / (1.0 - 0.55);
    return vec2f(1.7 * sum, 1.0 - seen / all);
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
