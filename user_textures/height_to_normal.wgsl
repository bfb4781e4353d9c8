/// A normal in the world from an image of heights. For heights that other textures give, drive the material's `bump`.
/// @group images
/// @param file   heights: white is high [data]
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param scale  how strongly it leans [-10 .. 10] [soft 0 .. 2] = 1
/// @param tiling how often it repeats in one unit of uv [soft 0.1 .. 20] = (1, 1)
fn userProc(file: sam2D, texcoord: vec4f, scale: f32, tiling: vec2f) -> vec3f {
    let size = max(texSize(file), vec2f(1.0));
    let pixels = texcoord.w * max(abs(tiling.x) * size.x, abs(tiling.y) * size.y);
    let lod = log2(max(pixels, 1.0));
    let step = vec2f(max(pixels, 1.0)) / size;
    let uv = texcoord.xy * tiling;
    let across = tex2DLod(file, uv + vec2f(step.x, 0.0), lod).x - tex2DLod(file, uv - vec2f(step.x, 0.0), lod).x;
    let along = tex2DLod(file, uv + vec2f(0.0, step.y), lod).x - tex2DLod(file, uv - vec2f(0.0, step.y), lod).x;
    let slope = 0.1 * scale * vec2f(across / step.x, along / step.y) * 0.5;
    let n = readAttr(Normal).xyz;
    let t = readAttr(Tangent).xyz;
    let b = readAttr(Bitangent).xyz;
    return normalize(n - slope.x * t + slope.y * b);
}
