/// A checkerboard over the first texture coordinates, filtered exactly over the pixel: from afar it becomes the
/// mean of its colours.
/// @param color_a colour of the first squares [color] = #d9d9d9
/// @param color_b colour of the other squares [color] = #333333
/// @param scale   squares per unit of uv [0.1 .. 1000] [soft 1 .. 64] [log] = 8
fn userProc(color_a: vec3f, color_b: vec3f, scale: f32) -> vec3f {
    let p = readAttr(TexCoord0).xy * scale;
    let width = max(readAttr(Footprint).y * scale, 1e-4);
    let side = mean_of_wave(p.x, width) * mean_of_wave(p.y, width);
    return mix(color_b, color_a, 0.5 + 0.5 * side);
}

// Mean over [x - width/2, x + width/2] of the square wave that is 1 on [0, 1), -1 on [1, 2), and so on.
fn mean_of_wave(x: f32, width: f32) -> f32 {
    // Far from the origin the difference of two integrals would have no digits left.
    let near = x - 2.0 * floor(0.5 * x);
    let mean = (integral_of_wave(near + 0.5 * width) - integral_of_wave(near - 0.5 * width)) / width;
    return clamp(mean, -1.0, 1.0);
}

fn integral_of_wave(x: f32) -> f32 {
    return 1.0 - abs(2.0 * fract(0.5 * x) - 1.0);
}
