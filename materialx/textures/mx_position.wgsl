/// The position in the object's own space; its fourth component is the width of the pixel.
/// @param position where [attr LocalPos]
fn userProc(position: vec4f) -> vec4f {
    return position;
}
