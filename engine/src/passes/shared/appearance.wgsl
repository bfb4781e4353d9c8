// What a surface looks like at a hit, before light comes in: the material's constants, its glTF textures, and what its
// texture program gave in their place.
//!include shared/outputs.wgsl
//!include shared/paths.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/surface.wgsl

// Whether the texture program gave this output.
fn gives(slot: u32, outputs: u32, which: u32) -> bool {
    return has_programs && has_output(slot, outputs, which);
}

fn driven_vector(slot: u32, outputs: u32, which: u32) -> vec3f {
    let at = result_place(slot, outputs, which);
    return vec3f(result_read(slot, at), result_read(slot, at + 1u), result_read(slot, at + 2u));
}

// What the texture program gave, or else the material's own value.
fn scalar_or(slot: u32, outputs: u32, which: u32, otherwise: f32) -> f32 {
    if (gives(slot, outputs, which)) {
        return result_read(slot, result_place(slot, outputs, which));
    }
    return otherwise;
}

fn color_or(slot: u32, outputs: u32, which: u32, otherwise: vec3f) -> vec3f {
    if (gives(slot, outputs, which)) {
        return max(driven_vector(slot, outputs, which), vec3f(0.0));
    }
    return otherwise;
}

// Normal map number `texture` in the frame of the interpolated normal; that normal where there is none.
fn mapped_normal(s: Surface, material: u32, instance: u32, texture: u32, map: vec3f, scale: f32) -> vec3f {
    if ((materials[material].texture_mask & (1u << texture)) == 0u) {
        return visible_normal(s.shading_normal, s);
    }
    let texel = map * 2.0 - 1.0;
    // The map is made for the front: undo the flip, perturb, flip again.
    let normal = select(-s.shading_normal, s.shading_normal, s.front);
    let tangent = surface_tangent(s, instance, normal);
    let bitangent = cross(normal, tangent.xyz) * tangent.w;
    let mapped = tangent.xyz * (texel.x * scale) + bitangent * (texel.y * scale) + normal * texel.z;
    let length2 = dot(mapped, mapped);
    if (length2 < 1e-12) {
        return visible_normal(s.shading_normal, s);
    }
    // Seen at a slant some of its slopes face away, which would be black.
    return visible_normal(select(-mapped, mapped, s.front) * inverseSqrt(length2), s);
}

// A shading normal that the viewer sees: one that is bent too far is bent back, also that of a smooth surface of few triangles near its rim.
fn visible_normal(normal: vec3f, s: Surface) -> vec3f {
    let cosine = dot(normal, s.wo);
    // What is flat leans no farther than it does.
    let least = min(0.01, 0.5 * dot(s.geometric_normal, s.wo));
    if (cosine >= least) {
        return normal;
    }
    return normalize(normal + s.wo * (least - cosine));
}

fn is_direction(v: vec3f) -> bool {
    let length2 = dot(v, v);
    return length2 > 1e-12 && length2 < 1e12;
}

fn base_color_at(slot: u32, driven: u32, material: u32, s: Surface, texel: vec4f) -> vec3f {
    if (gives(slot, driven, OUTPUT_BASE_COLOR)) {
        return driven_vector(slot, driven, OUTPUT_BASE_COLOR);
    }
    return materials[material].base_color.xyz * texel.xyz * interpolate_color(s.triangle, s.weights).xyz;
}

fn metallic_at(slot: u32, driven: u32, material: u32, texel: vec4f) -> f32 {
    return scalar_or(slot, driven, OUTPUT_METALLIC, materials[material].metallic * texel.z);
}

fn roughness_at(slot: u32, driven: u32, material: u32, texel: vec4f) -> f32 {
    return scalar_or(slot, driven, OUTPUT_ROUGHNESS, materials[material].roughness * texel.y);
}

// Radiance on the sides that emit.
fn emission_at(slot: u32, driven: u32, material: u32, texel: vec4f) -> vec3f {
    var emission = materials[material].emission;
    if (gives(slot, driven, OUTPUT_EMISSION)) {
        emission = driven_vector(slot, driven, OUTPUT_EMISSION);
    } else if (max_component(emission) > 0.0) {
        emission *= texel.xyz;
    }
    return emission * max(scalar_or(slot, driven, OUTPUT_EMISSION_STRENGTH, 1.0), 0.0);
}

// The normal with the material's normal map, then with what the texture program says.
fn shading_normal_at(slot: u32, driven: u32, material: u32, s: Surface, instance: u32, texel: vec4f) -> vec3f {
    let scale = scalar_or(slot, driven, OUTPUT_NORMAL_SCALE, materials[material].normal_scale);
    var normal = mapped_normal(s, material, instance, TEXTURE_NORMAL, texel.xyz, scale);
    if (gives(slot, driven, OUTPUT_NORMAL)) {
        let given = driven_vector(slot, driven, OUTPUT_NORMAL);
        if (is_direction(given)) {
            normal = visible_normal(normalize(given), s);
        }
    }
    if (gives(slot, driven, OUTPUT_BUMP)) {
        // Mikkelsen, "Bump Mapping Unparametrized Surfaces on the GPU", 2010: the normal leans against the slope.
        let rise = driven_vector(slot, driven, OUTPUT_BUMP);
        let leaning = normal - (rise - normal * dot(rise, normal));
        if (is_direction(leaning)) {
            normal = visible_normal(normalize(leaning), s);
        }
    }
    return normal;
}
