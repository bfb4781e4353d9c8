/// An image projected along x, y and z, for surfaces without texture coordinates. The projections run into each other where
/// the surface is oblique to two of them.
/// @group images
/// @param file   the image
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param normal which way the surface looks [attr LocalNormal]
/// @param size   width of one image [0.001 .. 100] [soft 0.05 .. 5] [log] [unit m] = 1
/// @param blend  how soft the projections run into each other [0 .. 1] [percent] = 0.3
fn userProc(file: sam2D, position: vec4f, normal: vec3f, size: f32, blend: f32) -> vec4f {
    let p = position.xyz / max(size, 1e-4);
    let pixels = position.w / max(size, 1e-4) * max(texSize(file).x, texSize(file).y);
    let lod = log2(max(pixels, 1.0));
    let weights = triplanarWeights(normal, blend);
    // Seen from outside no picture is mirrored.
    let side = select(vec3f(1.0), vec3f(-1.0), normal < vec3f());
    var sum = vec4f();
    if weights.x > 0.002 {
        sum += weights.x * tex2DLod(file, vec2f(-p.z * side.x, -p.y), lod);
    }
    if weights.y > 0.002 {
        sum += weights.y * tex2DLod(file, vec2f(p.x, p.z * side.y), lod);
    }
    if weights.z > 0.002 {
        sum += weights.z * tex2DLod(file, vec2f(p.x * side.z, -p.y), lod);
    }
    return sum;
}
