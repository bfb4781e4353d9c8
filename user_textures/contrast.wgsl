/// Contrast about a pivot, as MaterialX's node of that name.
/// @group colour
/// @param color  what goes in [color] = #8a6a4f
/// @param amount 0 leaves the pivot only, 1 leaves all as it is [0 .. 4] = 1.5
/// @param pivot  what stays as it is [0 .. 1] = 0.18
fn userProc(color: vec4f, amount: f32, pivot: f32) -> vec4f {
    return vec4f((color.rgb - pivot) * amount + pivot, color.a);
}
