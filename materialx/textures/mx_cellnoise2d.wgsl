/// @use mx_jenkins
/// A random number for each cell.
/// @param texcoord where [attr TexCoord0]
fn userProc(texcoord: vec4f) -> f32 {
    return cell2(texcoord.xy);
}
