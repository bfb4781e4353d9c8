
// Standard functions: sums of octaves of gradient noise. `octaves` is 1 to 12, a fraction is a weaker last one; each octave is
// `lacunarity` times finer and `gain` times weaker than the one before. `pixel` is the width of the pixel in units of p: octaves
// finer than that fade away. 0 shows them all.

// How much of an octave is shown in which a feature is of size 1.
fn octaveSeen(pixel: f32) -> f32 { return 1.0 - smoothstep(0.3, 0.7, pixel); }

// Each octave is moved, or their lattices would meet in the origin.
fn octaveOffset(octave: i32) -> vec3f { return vec3f(17.3, 5.9, 31.1) * f32(octave); }

// Sum of the octaves' strengths.
fn fractalWeight(octaves: f32, gain: f32) -> f32 {
    var weight = 0.0;
    var amplitude = 1.0;
    for (var octave = 0; octave < 12; octave++) {
        weight += amplitude * saturate(octaves - f32(octave));
        amplitude *= gain;
    }
    return max(weight, 1e-6);
}

// Share of that sum that the pixel leaves.
fn fractalSeen(octaves: f32, lacunarity: f32, gain: f32, pixel: f32) -> f32 {
    var seen = 0.0;
    var amplitude = 1.0;
    var frequency = 1.0;
    for (var octave = 0; octave < 12; octave++) {
        seen += amplitude * saturate(octaves - f32(octave)) * octaveSeen(pixel * frequency);
        amplitude *= gain;
        frequency *= lacunarity;
    }
    return seen / fractalWeight(octaves, gain);
}

// Fractal noise, about -1 to 1.
fn fbm2D(p: vec2f, octaves: f32, lacunarity: f32, gain: f32, pixel: f32) -> f32 {
    let settled = settled2(p);
    var sum = 0.0;
    var amplitude = 1.0;
    var frequency = 1.0;
    for (var octave = 0; octave < 12; octave++) {
        let shown = saturate(octaves - f32(octave)) * octaveSeen(pixel * frequency);
        if shown <= 0.0 {
            break; // all further octaves are finer still
        }
        sum += amplitude * shown * perlin2D(settled * frequency + octaveOffset(octave).xy);
        amplitude *= gain;
        frequency *= lacunarity;
    }
    return 1.6 * sum / fractalWeight(octaves, gain);
}
fn fbm3D(p: vec3f, octaves: f32, lacunarity: f32, gain: f32, pixel: f32) -> f32 {
    let settled = settled3(p);
    var sum = 0.0;
    var amplitude = 1.0;
    var frequency = 1.0;
    for (var octave = 0; octave < 12; octave++) {
        let shown = saturate(octaves - f32(octave)) * octaveSeen(pixel * frequency);
        if shown <= 0.0 {
            break;
        }
        sum += amplitude * shown * perlin3D(settled * frequency + octaveOffset(octave));
        amplitude *= gain;
        frequency *= lacunarity;
    }
    return 1.6 * sum / fractalWeight(octaves, gain);
}
fn fbm4D(p: vec4f, octaves: f32, lacunarity: f32, gain: f32, pixel: f32) -> f32 {
    let settled = settled4(p);
    var sum = 0.0;
    var amplitude = 1.0;
    var frequency = 1.0;
    for (var octave = 0; octave < 12; octave++) {
        let shown = saturate(octaves - f32(octave)) * octaveSeen(pixel * frequency);
        if shown <= 0.0 {
            break;
        }
        sum += amplitude * shown * perlin4D(settled * frequency + vec4f(octaveOffset(octave), 7.7 * f32(octave)));
        amplitude *= gain;
        frequency *= lacunarity;
    }
    return 1.6 * sum / fractalWeight(octaves, gain);
}

// Three independent fractal noises, to push a position about; each about -1 to 1.
fn fbmVector3D(p: vec3f, octaves: f32, lacunarity: f32, gain: f32, pixel: f32) -> vec3f {
    return vec3f(
        fbm3D(p, octaves, lacunarity, gain, pixel),
        fbm3D(p + vec3f(19.1, 73.7, 41.3), octaves, lacunarity, gain, pixel),
        fbm3D(p + vec3f(-57.9, 11.3, 88.1), octaves, lacunarity, gain, pixel),
    );
}

// Sum of absolute values: creases at 0, about 0 to 1. What a pixel hides has its mean.
fn turbulence3D(p: vec3f, octaves: f32, lacunarity: f32, gain: f32, pixel: f32) -> f32 {
    let settled = settled3(p);
    var sum = 0.0;
    var amplitude = 1.0;
    var frequency = 1.0;
    for (var octave = 0; octave < 12; octave++) {
        let present = saturate(octaves - f32(octave));
        if present <= 0.0 {
            break;
        }
        let seen = octaveSeen(pixel * frequency);
        var height = 0.154;
        if seen > 0.0 {
            height = mix(height, abs(perlin3D(settled * frequency + octaveOffset(octave))), seen);
        }
        sum += amplitude * present * height;
        amplitude *= gain;
        frequency *= lacunarity;
    }
    return 1.6 * sum / fractalWeight(octaves, gain);
}
fn turbulence2D(p: vec2f, octaves: f32, lacunarity: f32, gain: f32, pixel: f32) -> f32 {
    let settled = settled2(p);
    var sum = 0.0;
    var amplitude = 1.0;
    var frequency = 1.0;
    for (var octave = 0; octave < 12; octave++) {
        let present = saturate(octaves - f32(octave));
        if present <= 0.0 {
            break;
        }
        let height = abs(perlin2D(settled * frequency + octaveOffset(octave).xy));
        sum += amplitude * present * mix(0.14, height, octaveSeen(pixel * frequency));
        amplitude *= gain;
        frequency *= lacunarity;
    }
    return 1.6 * sum / fractalWeight(octaves, gain);
}

// Rounded heaps with creases between them: turbulence spread over -1 to 1.
fn billow3D(p: vec3f, octaves: f32, lacunarity: f32, gain: f32, pixel: f32) -> f32 {
    return 2.0 * turbulence3D(p, octaves, lacunarity, gain, pixel) - 1.0;
}

// Sharp ridges that carry finer ones (Musgrave 1998), about 0 to the square of `offset`: 1 is usual. The larger it is, the broader
// ridges are, too.
fn ridged3D(p: vec3f, octaves: f32, lacunarity: f32, gain: f32, offset: f32, pixel: f32) -> f32 {
    let settled = settled3(p);
    var sum = 0.0;
    var weight = 1.0;
    var amplitude = 1.0;
    var frequency = 1.0;
    for (var octave = 0; octave < 12; octave++) {
        let present = saturate(octaves - f32(octave));
        if present <= 0.0 {
            break;
        }
        let seen = octaveSeen(pixel * frequency);
        var ridge = 0.43 * offset * offset * (0.2 + 0.8 * offset);
        if seen > 0.0 {
            let height = max(offset - 2.4 * abs(perlin3D(settled * frequency + octaveOffset(octave))), 0.0);
            ridge = mix(ridge, height * height, seen);
        }
        sum += amplitude * present * weight * ridge;
        weight = saturate(2.0 * ridge * weight);
        amplitude *= gain;
        frequency *= lacunarity;
    }
    return sum / fractalWeight(octaves, gain);
}
