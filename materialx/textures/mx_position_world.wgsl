/// The position in the world; its fourth component is the width of the pixel.
/// @param position where [attr WorldPos]
fn userProc(position: vec4f) -> vec4f {
    return position;
}
