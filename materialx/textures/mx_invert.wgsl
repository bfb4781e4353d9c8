/// The amount less what goes in.
/// @param in     what goes in = (0, 0, 0, 0)
/// @param amount how much = (1, 1, 1, 1)
fn userProc(in: vec4f, amount: vec4f) -> vec4f {
    return amount - in;
}
