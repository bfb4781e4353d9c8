/// @use mx_shapes
/// A line from one point to another.
/// @param texcoord where [attr TexCoord0]
/// @param center   shift
/// @param radius   half its width = 0.1
/// @param point1   beginning = (0.25, 0.25)
/// @param point2   end = (0.75, 0.75)
fn userProc(texcoord: vec4f, center: vec2f, radius: f32, point1: vec2f, point2: vec2f) -> f32 {
    return line(texcoord.xy - center, point1, point2, radius);
}
