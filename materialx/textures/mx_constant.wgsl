/// A value.
/// @param value the value = (0, 0, 0, 0)
fn userProc(value: vec4f) -> vec4f {
    return value;
}
