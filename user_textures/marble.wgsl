/// Marble: veins of several sizes through warped stone. The fourth component is the strength of the vein.
/// @group materials
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale  veins per metre [0.01 .. 1000] [soft 0.5 .. 20] [log] = 2.5
/// @param warp   how far veins bend [0 .. 3] = 1
/// @param width  of the veins [0.01 .. 1] [percent] = 0.25
/// @param stone  colour of the stone [color] = #e9e6e0
/// @param shade  colour of its clouds [color] = #bdbab4
/// @param vein   colour of the veins [color] = #5b5f63
fn userProc(position: vec4f, scale: f32, warp: f32, width: f32, stone: vec3f, shade: vec3f, vein: vec3f) -> vec4f {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    let push = fbmVector3D(p * 0.8, 4.0, 2.1, 0.5, pixel);
    let q = p + warp * push;
    let clouds = fbm3D(q * 0.7 + 9.0, 5.0, 2.1, 0.55, pixel);
    // Veins are where a noise crosses zero; finer ones branch off and fade in and out.
    var strength = 0.0;
    for (var layer = 0; layer < 3; layer++) {
        let s = pow(2.1, f32(layer));
        let line = abs(perlin3D(q * s + 31.7 * f32(layer))) * 4.0 / max(width, 0.01);
        let branch = smoothstep(-0.15, 0.45, perlin3D(p * 0.6 * s + 5.3 * f32(layer)));
        let present = mix(0.26, branch, octaveSeen(pixel * 0.6 * s));
        // Veins thinner than the pixel are what they cover on the whole.
        let cover = mix(width * (0.55 - 0.09 * width), saturate(1.0 - line), octaveSeen(pixel * s * 3.0));
        strength += pow(0.62, f32(layer)) * present * cover;
    }
    let s = saturate(strength * 1.1);
    let body = mix(shade, stone, smoothstep(-0.45, 0.35, clouds));
    // The mean of the curve is not the curve of the mean.
    let tint = mix(s * (0.7 + 0.155 * width), s * s * (3.0 - 2.0 * s), octaveSeen(pixel * 3.0));
    return vec4f(mix(body, vein, tint), s);
}
