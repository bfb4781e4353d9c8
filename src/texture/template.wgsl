/// What the texture shows, in one sentence.
///
/// Lines with @param describe parameters: a label, the range or other keys in brackets, and the default. The language is
/// described in docs/texture-language.md; in a look file this texture is `texture = "NAME"`.
/// @param base   colour between the spots [color] = #d8c8a8
/// @param spot   colour of the spots [color] = #7a3b12
/// @param scale  spots per metre [0.1 .. 100] [soft 1 .. 20] [log] = 5
/// @param radius size of the spots, 1 is half the distance between them [0 .. 1] = 0.6
fn userProc(base: vec3f, spot: vec3f, scale: f32, radius: f32) -> vec3f {
    // Attributes of the hit are read by name; all of them are vec4f.
    let position = readAttr(LocalPos).xyz;
    let distance = distance_to_spot(position * scale);

    // What is finer than the pixel only makes noise: blur edges by the pixel's width, here in units of a spot.
    let width = max(2.0 * readAttr(Footprint).z * scale, 1e-4);
    let inside = 1.0 - smoothstep(radius - width, radius + width, distance);

    return mix(base, spot, inside);
}

// Helpers, structs and constants belong to this file; other textures may use the same names.
fn distance_to_spot(p: vec3f) -> f32 {
    return 2.0 * length(fract(p) - 0.5);
}
