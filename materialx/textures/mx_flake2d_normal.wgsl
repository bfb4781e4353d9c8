/// @use mx_flakes
/// The normal of the flake, the surface's own where there is none.
/// @param size      width of a flake = 0.01
/// @param roughness how far flakes are tilted = 0.1
/// @param coverage  how much of the surface has flakes = 0.5
/// @param texcoord  where [attr TexCoord0]
/// @param normal    shading normal [attr Normal]
/// @param tangent   tangent [attr Tangent]
/// @param bitangent bitangent [attr Bitangent]
fn userProc(
    size: f32,
    roughness: f32,
    coverage: f32,
    texcoord: vec4f,
    normal: vec3f,
    tangent: vec3f,
    bitangent: vec3f,
) -> vec3f {
    return flakeNormal(vec3f(texcoord.xy, 0.0), size, coverage, roughness, normal, tangent, bitangent);
}
