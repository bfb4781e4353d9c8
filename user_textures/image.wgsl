/// An image with a transform of its own. How it repeats, and whether it holds colours or numbers, is said where the look
/// names the file. Far away its smaller copies are read, so that it doesn't sparkle.
/// @group images
/// @param file     the image
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param uvtiling how often it repeats in one unit of uv [soft 0.1 .. 20] = (1, 1)
/// @param uvoffset shift in uv [soft -1 .. 1]
/// @param rotation turn about the middle, counterclockwise [angle] [-6.2832 .. 6.2832]
/// @param gain     factor on all that is read [color] = (1, 1, 1, 1)
fn userProc(
    file: sam2D,
    texcoord: vec4f,
    uvtiling: vec2f,
    uvoffset: vec2f,
    rotation: f32,
    gain: vec4f,
) -> vec4f {
    let uv = rotate2D(texcoord.xy - 0.5, rotation) + 0.5;
    let size = texSize(file);
    let pixels = texcoord.w * max(abs(uvtiling.x) * size.x, abs(uvtiling.y) * size.y);
    return gain * tex2DLod(file, uv * uvtiling + uvoffset, log2(max(pixels, 1.0)));
}
