/// @use mx_flakes
/// A number of the flake, 0 where there is none; a random number of it; and how far on top it lies.
/// @param size     width of a flake = 0.01
/// @param coverage how much of the surface has flakes = 0.5
/// @param position where [attr LocalPos]
fn userProc(size: f32, coverage: f32, position: vec4f) -> vec3f {
    return flakeFacts(position.xyz, size, coverage);
}
