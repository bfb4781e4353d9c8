fn unit(v: vec3f) -> vec3f {
    return v / max(length(v), 1e-30);
}

/// A normal of the surface from the colour of a normal map.
/// @param in        colour of the map = (0.5, 0.5, 1)
/// @param scale     how strongly it leans = (1, 1)
/// @param normal    shading normal [attr Normal]
/// @param tangent   tangent [attr Tangent]
/// @param bitangent bitangent [attr Bitangent]
fn userProc(in: vec3f, scale: vec2f, normal: vec3f, tangent: vec3f, bitangent: vec3f) -> vec3f {
    let v = 2.0 * in - 1.0;
    let t = unit(tangent - dot(tangent, normal) * normal);
    let b = unit(bitangent - dot(bitangent, normal) * normal - dot(bitangent, t) * t);
    let sum = t * v.x * scale.x + b * v.y * scale.y + normal * v.z;
    return select(unit(sum), normal, all(in == vec3f()));
}
