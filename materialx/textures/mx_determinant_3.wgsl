/// The determinant of a matrix of three rows.
/// @param row1 first row = (1, 0, 0)
/// @param row2 second row = (0, 1, 0)
/// @param row3 third row = (0, 0, 1)
fn userProc(row1: vec3f, row2: vec3f, row3: vec3f) -> f32 {
    return dot(row1, cross(row2, row3));
}
