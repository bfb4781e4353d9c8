/// An image that covers large surfaces without showing that it repeats (Mikkelsen 2022, after Heitz and Neyret 2018): each of
/// overlapping hexagons shows another part of it, turned.
/// @group images
/// @param file            the image
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param tiling          images per unit of uv [0.01 .. 1000] [soft 1 .. 30] [log] = 4
/// @param rotation        how far hexagons are turned [0 .. 1] [percent] = 1
/// @param falloffcontrast how narrow the borders are [0.5 .. 1] = 0.6
/// @param falloff         how sharp the borders are [1 .. 16] = 7
fn userProc(file: sam2D, texcoord: vec4f, tiling: f32, rotation: f32, falloffcontrast: f32, falloff: f32) -> vec4f {
    let p = texcoord.xy * tiling * 3.4641016;
    let skewed = vec2f(p.x - 0.57735027 * p.y, 1.1547005 * p.y);
    let base = floor(skewed);
    let f = skewed - base;
    // The triangle of the grid, and how near its three corners are.
    let upper = f.x + f.y > 1.0;
    let near = select(vec3f(1.0 - f.x - f.y, f.x, f.y), vec3f(f.x + f.y - 1.0, 1.0 - f.y, 1.0 - f.x), upper);
    let first = base + select(vec2f(), vec2f(1.0), upper);
    let second = base + vec2f(1.0, 0.0);
    let third = base + vec2f(0.0, 1.0);
    let a = hex_part(file, texcoord, tiling, first, rotation);
    let b = hex_part(file, texcoord, tiling, second, rotation);
    let c = hex_part(file, texcoord, tiling, third, rotation);
    // The brighter part wins a little: details end at their own borders.
    let bright = vec3f(luminance(a.rgb), luminance(b.rgb), luminance(c.rgb));
    let contrast = mix(vec3f(1.0), 0.05 + saturate(bright), 2.0 * saturate(falloffcontrast) - 1.0);
    let weights = contrast * pow(max(near, vec3f(1e-4)), vec3f(falloff));
    return (weights.x * a + weights.y * b + weights.z * c) / (weights.x + weights.y + weights.z);
}

fn hex_part(file: sam2D, texcoord: vec4f, tiling: f32, corner: vec2f, rotation: f32) -> vec4f {
    let r = random2to3(vec2u(vec2i(corner)));
    let middle = vec2f(corner.x + 0.5 * corner.y, 0.8660254 * corner.y) / 3.4641016;
    let uv = rotate2D(texcoord.xy * tiling - middle, rotation * 6.2831853 * (r.z - 0.5)) + middle + r.xy;
    let pixels = texcoord.w * tiling * max(texSize(file).x, texSize(file).y);
    return tex2DLod(file, uv, log2(max(pixels, 1.0)));
}
