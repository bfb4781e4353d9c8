/// The determinant of a matrix of four rows.
/// @param row1 first row = (1, 0, 0, 0)
/// @param row2 second row = (0, 1, 0, 0)
/// @param row3 third row = (0, 0, 1, 0)
/// @param row4 fourth row = (0, 0, 0, 1)
fn userProc(row1: vec4f, row2: vec4f, row3: vec4f, row4: vec4f) -> f32 {
    return determinant(mat4x4f(row1, row2, row3, row4));
}
