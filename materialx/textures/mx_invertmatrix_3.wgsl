/// A row of the inverse of a matrix of three rows; 0 where there is no inverse.
/// @param row1 first row = (1, 0, 0)
/// @param row2 second row = (0, 1, 0)
/// @param row3 third row = (0, 0, 1)
/// @param row  which row, from 0 = 0
fn userProc(row1: vec3f, row2: vec3f, row3: vec3f, row: i32) -> vec3f {
    let columns = transpose(mat3x3f(cross(row2, row3), cross(row3, row1), cross(row1, row2)));
    let scale = dot(row1, cross(row2, row3));
    return select(columns[clamp(row, 0, 2)] / scale, vec3f(), scale == 0.0);
}
