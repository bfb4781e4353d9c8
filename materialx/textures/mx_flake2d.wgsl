/// @use mx_flakes
/// A number of the flake, 0 where there is none; a random number of it; and how far on top it lies.
/// @param size     width of a flake = 0.01
/// @param coverage how much of the surface has flakes = 0.5
/// @param texcoord where [attr TexCoord0]
fn userProc(size: f32, coverage: f32, texcoord: vec4f) -> vec3f {
    return flakeFacts(vec3f(texcoord.xy, 0.0), size, coverage);
}
