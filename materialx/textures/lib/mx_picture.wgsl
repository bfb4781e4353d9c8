//! Images whose v goes upwards, and the transform of glTF's image nodes.

fn picture(file: sam2D, at: vec4f, outside: vec4f, bounds: u32) -> vec4f {
    let beyond = (at.xy < vec2f()) | (at.xy > vec2f(1.0));
    if (beyond.x && (bounds & 1u) != 0u) || (beyond.y && (bounds & 2u) != 0u) {
        return outside;
    }
    let size = texSize(file);
    let pixels = at.w * max(size.x, size.y);
    return tex2DLod(file, vec2f(at.x, 1.0 - at.y), log2(max(pixels, 1.0)));
}

// As `place2d` with the scale inverted, the turn reversed and the shift mirrored along u.
fn placed(texcoord: vec4f, pivot: vec2f, scale: vec2f, degrees: f32, offset: vec2f, order: u32) -> vec4f {
    let p = texcoord.xy - pivot;
    let turn = radians(degrees);
    let shift = offset * vec2f(-1.0, 1.0);
    let first = rotate2D(p * scale, turn) - shift;
    let uv = select(first, rotate2D(p - shift, turn) * scale, order == 1u);
    return vec4f(uv + pivot, 0.0, texcoord.w * max(abs(scale.x), abs(scale.y)));
}
