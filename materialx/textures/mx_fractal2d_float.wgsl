/// @use mx_jenkins
/// Octaves of gradient noise.
/// @param amplitude  factor on the noise = 1
/// @param octaves    octaves = 3
/// @param lacunarity how much finer each octave is = 2
/// @param diminish   how much weaker each octave is = 0.5
/// @param texcoord   where [attr TexCoord0]
fn userProc(amplitude: f32, octaves: u32, lacunarity: f32, diminish: f32, texcoord: vec4f) -> f32 {
    var p = texcoord.xy;
    var sum = f32();
    var weight = 1.0;
    for (var i = 0u; i < min(octaves, 32u); i++) {
        sum += weight * perlin2(p);
        weight *= diminish;
        p *= lacunarity;
    }
    return amplitude * sum;
}
