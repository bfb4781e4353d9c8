/// Texture coordinates moved, turned and scaled about a pivot.
/// @param texcoord       where [attr TexCoord0]
/// @param pivot          what stays where it is
/// @param scale          size of what is placed = (1, 1)
/// @param rotate         degrees = 0
/// @param offset         shift
/// @param operationorder 0 scale, turn, shift; 1 shift, turn, scale = 0
fn userProc(texcoord: vec4f, pivot: vec2f, scale: vec2f, rotate: f32, offset: vec2f, operationorder: u32) -> vec4f {
    let safe = select(scale, vec2f(1e-6), abs(scale) < vec2f(1e-6));
    let p = texcoord.xy - pivot;
    let turn = -radians(rotate);
    var uv = rotate2D(p / safe, turn) - offset;
    if operationorder == 1u {
        uv = rotate2D(p - offset, turn) / safe;
    }
    return vec4f(uv + pivot, 0.0, texcoord.w / min(abs(safe.x), abs(safe.y)));
}
