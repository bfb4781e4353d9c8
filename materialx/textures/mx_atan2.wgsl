/// The angle of a direction in radians.
/// @param iny y = (0, 0, 0, 0)
/// @param inx x = (1, 1, 1, 1)
fn userProc(iny: vec4f, inx: vec4f) -> vec4f {
    let none = (iny == vec4f()) & (inx == vec4f());
    return select(atan2(iny, inx), vec4f(), none);
}
