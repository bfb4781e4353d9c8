/// Moves, turns and scales texture coordinates about a pivot, as MaterialX's node of that name does where v points up. Larger
/// scales make the pattern larger.
/// @group coordinates
/// @param texcoord where; link `coordinates` for others [attr TexCoord0]
/// @param pivot    what stays where it is [soft 0 .. 1] = (0.5, 0.5)
/// @param scale    size of the pattern [soft 0.1 .. 4] = (1, 1)
/// @param rotate   turn, counterclockwise [angle] [-6.2832 .. 6.2832]
/// @param offset   shift of the pattern, to the right and down [soft -1 .. 1]
fn userProc(texcoord: vec4f, pivot: vec2f, scale: vec2f, rotate: f32, offset: vec2f) -> vec4f {
    let safe = select(scale, vec2f(1e-4), abs(scale) < vec2f(1e-4));
    // v grows downwards.
    let uv = rotate2D((texcoord.xy - pivot) / safe, rotate) - offset + pivot;
    return vec4f(uv, texcoord.z, texcoord.w / min(abs(safe.x), abs(safe.y)));
}
