/// @use mx_jenkins
/// Octaves of four gradient noises.
/// @param amplitude  factor on the noise = (1, 1, 1, 1)
/// @param octaves    octaves = 3
/// @param lacunarity how much finer each octave is = 2
/// @param diminish   how much weaker each octave is = 0.5
/// @param texcoord   where [attr TexCoord0]
fn userProc(amplitude: vec4f, octaves: u32, lacunarity: f32, diminish: f32, texcoord: vec4f) -> vec4f {
    var p = texcoord.xy;
    var q = p + vec2f(19.0, 193.0);
    var sum = vec4f();
    var weight = 1.0;
    for (var i = 0u; i < min(octaves, 32u); i++) {
        sum += weight * vec4f(perlinOf3_2(p), perlin2(q));
        weight *= diminish;
        p *= lacunarity;
        q *= lacunarity;
    }
    return amplitude * sum;
}
