/// A vector, as a row, by a matrix of three rows.
/// @param in   the vector
/// @param row1 first row = (1, 0, 0)
/// @param row2 second row = (0, 1, 0)
/// @param row3 third row = (0, 0, 1)
fn userProc(in: vec3f, row1: vec3f, row2: vec3f, row3: vec3f) -> vec3f {
    return in.x * row1 + in.y * row2 + in.z * row3;
}
