/// @use mx_jenkins
/// Octaves of two gradient noises.
/// @param amplitude  factor on the noise = (1, 1, 1, 1)
/// @param octaves    octaves = 3
/// @param lacunarity how much finer each octave is = 2
/// @param diminish   how much weaker each octave is = 0.5
/// @param position   where [attr LocalPos]
fn userProc(amplitude: vec4f, octaves: u32, lacunarity: f32, diminish: f32, position: vec4f) -> vec4f {
    var p = position.xyz;
    var q = p + vec3f(19.0, 193.0, 17.0);
    var sum = vec4f();
    var weight = 1.0;
    for (var i = 0u; i < min(octaves, 32u); i++) {
        sum += weight * vec4f(perlin3(p), perlin3(q), 0.0, 0.0);
        weight *= diminish;
        p *= lacunarity;
        q *= lacunarity;
    }
    return amplitude * sum;
}
