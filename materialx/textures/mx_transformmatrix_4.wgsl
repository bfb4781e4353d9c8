/// A vector, as a row, by a matrix of four rows.
/// @param in   the vector = (0, 0, 0, 0)
/// @param row1 first row = (1, 0, 0, 0)
/// @param row2 second row = (0, 1, 0, 0)
/// @param row3 third row = (0, 0, 1, 0)
/// @param row4 fourth row = (0, 0, 0, 1)
fn userProc(in: vec4f, row1: vec4f, row2: vec4f, row3: vec4f, row4: vec4f) -> vec4f {
    return in.x * row1 + in.y * row2 + in.z * row3 + in.w * row4;
}
