
// Standard functions: ranges, turns, and patterns that don't flicker. `pixel` is the width of the pixel in units of x.

// x of the range from inLow to inHigh, in the range from outLow to outHigh; not restricted to it.
fn remap(x: f32, inLow: f32, inHigh: f32, outLow: f32, outHigh: f32) -> f32 {
    let width = inHigh - inLow;
    let t = (x - inLow) / select(width, 1e-6, abs(width) < 1e-6);
    return outLow + t * (outHigh - outLow);
}

// As smoothstep, with a second derivative that is continuous, too.
fn smootherstep(low: f32, high: f32, x: f32) -> f32 {
    let t = saturate((x - low) / max(high - low, 1e-6));
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

// x - y * floor(x / y): what is left, never negative for positive y.
fn modulo(x: f32, y: f32) -> f32 { return x - y * floor(x / y); }

// v turned counterclockwise by so many radians.
fn rotate2D(v: vec2f, angle: f32) -> vec2f {
    let c = cos(angle);
    let s = sin(angle);
    return vec2f(c * v.x - s * v.y, s * v.x + c * v.y);
}

// v turned about an axis of unit length (Rodrigues).
fn rotateAxis(v: vec3f, axis: vec3f, angle: f32) -> vec3f {
    let c = cos(angle);
    return c * v + sin(angle) * cross(axis, v) + (1.0 - c) * dot(axis, v) * axis;
}

// v turned about x, then y, then z.
fn rotateEuler(v: vec3f, angles: vec3f) -> vec3f {
    let x = rotateAxis(v, vec3f(1.0, 0.0, 0.0), angles.x);
    let y = rotateAxis(x, vec3f(0.0, 1.0, 0.0), angles.y);
    return rotateAxis(y, vec3f(0.0, 0.0, 1.0), angles.z);
}

// p itself. Compilers that would compute what p comes from again in each iteration find it computed.
fn settled2(p: vec2f) -> vec2f { return settled4(vec4f(p, 0.0, 0.0)).xy; }
fn settled3(p: vec3f) -> vec3f { return settled4(vec4f(p, 0.0)).xyz; }
fn settled4(p: vec4f) -> vec4f {
    var q = p;
    // Never so: but then q would be another value, so it has to be one of its own.
    if p.x > 1e38 {
        q = vec4f();
    }
    return q;
}

// How much the projections along x, y and z count on a surface with this normal; their sum is 1. `blend` 0 is sharp, 1 soft.
fn triplanarWeights(normal: vec3f, blend: f32) -> vec3f {
    let sharp = mix(16.0, 1.0, saturate(blend));
    let weights = pow(max(abs(normal), vec3f(1e-4)), vec3f(sharp));
    return weights / (weights.x + weights.y + weights.z);
}

// Mean over the pixel of the wave that is 1 on [0, 1), -1 on [1, 2), and so on.
fn squareWave(x: f32, pixel: f32) -> f32 {
    let width = max(pixel, 1e-4);
    // Far from the origin the difference of two integrals would have no digits left.
    let near = x - 2.0 * floor(0.5 * x);
    let mean = (squareWaveIntegral(near + 0.5 * width) - squareWaveIntegral(near - 0.5 * width)) / width;
    return clamp(mean, -1.0, 1.0);
}
fn squareWaveIntegral(x: f32) -> f32 { return 1.0 - abs(2.0 * fract(0.5 * x) - 1.0); }

// Mean over the pixel of the wave that is 1 on the first `share` of each unit, else 0.
fn pulseWave(x: f32, share: f32, pixel: f32) -> f32 {
    let width = max(pixel, 1e-4);
    let near = fract(x);
    let duty = saturate(share);
    let high = pulseIntegral(near + 0.5 * width, duty);
    return saturate((high - pulseIntegral(near - 0.5 * width, duty)) / width);
}
fn pulseIntegral(x: f32, share: f32) -> f32 { return share * floor(x) + min(fract(x), share); }

// 0 below the edge, 1 above it, over the pixel.
fn edgeStep(edge: f32, x: f32, pixel: f32) -> f32 { return saturate((x - edge) / max(pixel, 1e-6) + 0.5); }

// As smoothstep between two edges that lie at least a pixel apart.
fn softStep(low: f32, high: f32, x: f32, pixel: f32) -> f32 {
    let half = max(0.5 * (high - low), 0.7 * max(pixel, 1e-6));
    let middle = 0.5 * (low + high);
    return smoothstep(middle - half, middle + half, x);
}
