/// More or less contrast around a pivot.
/// @param in     what goes in = (0, 0, 0, 0)
/// @param amount how much = (1, 1, 1, 1)
/// @param pivot  what stays as it is = (0.5, 0.5, 0.5, 0.5)
fn userProc(in: vec4f, amount: vec4f, pivot: vec4f) -> vec4f {
    return (in - pivot) * amount + pivot;
}
