/// A row of the inverse of a matrix of four rows; 0 where there is no inverse.
/// @param row1 first row = (1, 0, 0, 0)
/// @param row2 second row = (0, 1, 0, 0)
/// @param row3 third row = (0, 0, 1, 0)
/// @param row4 fourth row = (0, 0, 0, 1)
/// @param row  which row, from 0 = 0
fn userProc(row1: vec4f, row2: vec4f, row3: vec4f, row4: vec4f, row: i32) -> vec4f {
    let whole = determinant(mat4x4f(row1, row2, row3, row4));
    // By Cramer's rule: each row in turn gives way to one of the identity.
    var unit = vec4f();
    unit[clamp(row, 0, 3)] = 1.0;
    let parts = vec4f(
        determinant(mat4x4f(unit, row2, row3, row4)),
        determinant(mat4x4f(row1, unit, row3, row4)),
        determinant(mat4x4f(row1, row2, unit, row4)),
        determinant(mat4x4f(row1, row2, row3, unit)),
    );
    return select(parts / whole, vec4f(), whole == 0.0);
}
