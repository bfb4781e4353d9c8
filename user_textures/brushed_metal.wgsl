/// Metal brushed in one direction: fine grooves from 0 to 1, for its roughness, bump or colour. With `round` the grooves go
/// round the middle of uv, as on the bottom of a pan.
/// @group surface
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param scale    grooves per unit of uv [1 .. 10000] [soft 50 .. 2000] [log] = 220
/// @param length   length of a groove over its width [1 .. 1000] [log] = 60
/// @param angle    direction [angle] [-3.1416 .. 3.1416] = 0
/// @param round    whether they go round = false
/// @param contrast of the grooves [0 .. 2] = 1
fn userProc(texcoord: vec4f, scale: f32, length: f32, angle: f32, round: bool, contrast: f32) -> f32 {
    let d = texcoord.xy - 0.5;
    let distance = sqrt(max(dot(d, d), 1e-10));
    // A groove is six cells of noise long, on a circle that closes.
    let around = d / distance * 0.95492966;
    let p = rotate2D(texcoord.xy, -angle);
    let pixel = texcoord.w * scale;
    var sum = 0.0;
    var weight = 0.0;
    for (var layer = 0; layer < 4; layer++) {
        let frequency = scale * pow(0.5, f32(layer));
        let amplitude = pow(0.8, f32(layer));
        let other = 13.7 * f32(layer);
        var groove = 0.0;
        if (round) {
            groove = valueNoise3D(vec3f(around + other, distance * frequency));
        } else {
            groove = valueNoise2D(vec2f(p.x * frequency / max(length, 1.0) + other, p.y * frequency));
        }
        sum += amplitude * octaveSeen(pixel * pow(0.5, f32(layer))) * groove;
        weight += amplitude;
    }
    return saturate(0.5 + 0.9 * contrast * sum / weight);
}
