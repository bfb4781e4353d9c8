/// A normal in the world from the colour of a normal map in tangent space: link the `.xyz` of an `image` to it, whose file has
/// `color_space = "linear"`, and the result to a material's `normal`.
/// @group surface
/// @param color colour of the map, as data = (0.5, 0.5, 1)
/// @param scale how strongly it leans [-10 .. 10] [soft 0 .. 2] = 1
/// @param flip  whether green points down, as in DirectX = false
fn userProc(color: vec3f, scale: f32, flip: bool) -> vec3f {
    let t = 2.0 * color - 1.0;
    let lean = scale * vec2f(t.x, select(t.y, -t.y, flip));
    let n = readAttr(Normal).xyz;
    let sum = lean.x * readAttr(Tangent).xyz + lean.y * readAttr(Bitangent).xyz + max(t.z, 0.01) * n;
    return normalize(sum);
}
