/// Moves, turns and scales places before other textures are looked up there: first the scale, then the turns about x, y and z,
/// then the location.
/// @group coordinates
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param location what is added [unit m] [soft -1 .. 1]
/// @param rotation about x, y and z [angle] [-6.2832 .. 6.2832]
/// @param scale    factor; 2 makes patterns half as large [soft 0.1 .. 10] = (1, 1, 1)
fn userProc(position: vec4f, location: vec3f, rotation: vec3f, scale: vec3f) -> vec4f {
    let p = rotateEuler(position.xyz * scale, rotation) + location;
    // A pixel is as wide as where it is stretched most.
    let stretch = max(abs(scale.x), max(abs(scale.y), abs(scale.z)));
    return vec4f(p, position.w * stretch);
}
