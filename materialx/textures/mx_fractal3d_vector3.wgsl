/// @use mx_jenkins
/// Octaves of three gradient noises.
/// @param amplitude  factor on the noise = (1, 1, 1, 1)
/// @param octaves    octaves = 3
/// @param lacunarity how much finer each octave is = 2
/// @param diminish   how much weaker each octave is = 0.5
/// @param position   where [attr LocalPos]
fn userProc(amplitude: vec4f, octaves: u32, lacunarity: f32, diminish: f32, position: vec4f) -> vec4f {
    var p = position.xyz;
    var sum = vec3f();
    var weight = 1.0;
    for (var i = 0u; i < min(octaves, 32u); i++) {
        sum += weight * perlinOf3_3(p);
        weight *= diminish;
        p *= lacunarity;
    }
    return amplitude * vec4f(sum, 0.0);
}
