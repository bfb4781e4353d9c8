fn hexNormal(color: vec3f, turn: f32, strength: f32, flip: bool, n: vec3f, tangent: vec3f, bitangent: vec3f) -> vec3f {
    let v = 2.0 * vec3f(color.x, select(color.y, 1.0 - color.y, flip), color.z) - 1.0;
    let along = rotateAxis(tangent, n, turn);
    let across = rotateAxis(bitangent, n, turn);
    let t = unit(along - dot(along, n) * n);
    let b = unit(across - dot(across, n) * n - dot(across, t) * t);
    return unit(strength * (t * v.x + b * v.y) + n * v.z);
}

fn unit(v: vec3f) -> vec3f {
    return v / max(length(v), 1e-30);
}

// As a slope of the surface: slopes can be added (Mikkelsen 2020).
fn slopeOf(n: vec3f, leaning: vec3f) -> vec3f {
    let d = dot(n, leaning);
    return (d * n - leaning) / max(abs(d), 1e-8);
}

/// @use mx_hextile
/// A normal map that doesn't show that it repeats, as a normal of the surface.
/// @param file          the normal map [data]
/// @param texcoord      where [attr TexCoord0]
/// @param tiling        repeats = (1, 1)
/// @param rotation      how much hexagons are turned = 1
/// @param rotationrange between these, in degrees = (0, 360)
/// @param scale         how much they are scaled = 1
/// @param scalerange    between these = (0.5, 2)
/// @param offset        how much they are shifted = 1
/// @param offsetrange   between these = (0, 1)
/// @param falloff       how sharp borders are = 0.5
/// @param strength      how strongly it leans = 1
/// @param flip_g        whether green points down = false
/// @param normal        shading normal [attr Normal]
/// @param tangent       tangent [attr Tangent]
/// @param bitangent     bitangent [attr Bitangent]
fn userProc(
    file: sam2D,
    texcoord: vec4f,
    tiling: vec2f,
    rotation: f32,
    rotationrange: vec2f,
    scale: f32,
    scalerange: vec2f,
    offset: f32,
    offsetrange: vec2f,
    falloff: f32,
    strength: f32,
    flip_g: bool,
    normal: vec3f,
    tangent: vec3f,
    bitangent: vec3f,
) -> vec3f {
    let tile = hexTile(texcoord, tiling, rotation, rotationrange, scale, scalerange, offset, offsetrange);
    let w = hexWeights(vec3f(1.0), tile.nearness, falloff);
    var slope = vec3f();
    for (var i = 0; i < 3; i++) {
        let color = picture(file, tile.at[i], vec4f(), 0u).rgb;
        let leaning = hexNormal(color, tile.turns[i], strength, flip_g, normal, tangent, bitangent);
        slope += saturate(w[i]) * slopeOf(normal, leaning);
    }
    return unit(normal - slope);
}
