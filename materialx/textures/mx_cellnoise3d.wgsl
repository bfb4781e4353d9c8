/// @use mx_jenkins
/// A random number for each cell.
/// @param position where [attr LocalPos]
fn userProc(position: vec4f) -> f32 {
    return cell3(position.xyz);
}
