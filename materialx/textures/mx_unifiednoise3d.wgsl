//! @use mx_worley

fn fractal(position: vec3f, octaves: u32, lacunarity: f32, diminish: f32) -> f32 {
    var p = position;
    var sum = 0.0;
    var weight = 1.0;
    for (var i = 0u; i < min(octaves, 32u); i++) {
        sum += weight * perlin3(p);
        weight *= diminish;
        p *= lacunarity;
    }
    return sum;
}

/// One of four noises.
/// @param position    where [attr LocalPos]
/// @param freq        frequency = (1, 1, 1)
/// @param offset      shift
/// @param jitter      how irregular = 1
/// @param outmin      what 0 becomes = 0
/// @param outmax      what 1 becomes = 1
/// @param clampoutput whether the result is held between both = true
/// @param octaves     octaves = 3
/// @param lacunarity  how much finer each octave is = 2
/// @param diminish    how much weaker each octave is = 0.5
/// @param kind        0 gradient, 1 cells, 2 distances, 3 fractal = 0
/// @param style       0 distances, 1 a number for each cell = 0
fn userProc(
    position: vec4f,
    freq: vec3f,
    offset: vec3f,
    jitter: f32,
    outmin: f32,
    outmax: f32,
    clampoutput: bool,
    octaves: u32,
    lacunarity: f32,
    diminish: f32,
    kind: u32,
    style: u32,
) -> f32 {
    let p = position.xyz * freq + offset;
    let turn = 90000.0 * (jitter - 1.0);
    let turned = rotateAxis(p, normalize(vec3f(0.1, 1.0, 0.0)), -radians(turn));
    var value = 0.0;
    switch kind {
        case 0u: { value = 0.5 * perlin3(turned) + 0.5; }
        case 1u: { value = cell3(turned); }
        case 2u: { value = worleyOf1_3(p, jitter, style == 1u); }
        default: { value = fractal(turned, octaves, lacunarity, diminish); }
    }
    let result = mix(outmin, outmax, value);
    return select(result, max(min(result, outmax), outmin), clampoutput);
}
