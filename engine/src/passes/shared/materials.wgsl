// Materials in memory. The struct `Material`, its flags (MATERIAL_...) and the numbers of its textures (TEXTURE_...,
// LAYER_...) are made from the table of parameters: `material_record`.
//!include generated/material.wgsl

struct TextureSlot {
    row_u: vec3f, // u' = dot(row_u, (u, v, 1))
    image: u32, // IMAGE_NONE: no texture
    row_v: vec3f,
    sampler: u32,
}

@group(0) @binding(14) var<storage, read> materials: array<Material>;

// Whether any material of the scene has a texture program.
override has_programs: bool = true;

// Whether the texture program runs for a hit of this material: after the last scattering only emission matters.
fn runs_program(flags: u32, is_last: bool) -> bool {
    return has_programs && (flags & select(MATERIAL_PROGRAM, MATERIAL_PROGRAM_LAST, is_last)) != 0u;
}

// The group of lights that what a material emits belongs to.
fn light_group(flags: u32) -> u32 {
    return flags >> MATERIAL_LIGHT_GROUP_SHIFT;
}

// Whether any material of the scene has a texture.
override has_textures: bool = true;

// The texel of a material's texture, or white where it has none.
fn material_texture(material: u32, texture: u32, triangle: vec4u, weights: vec3f) -> vec4f {
    let image = materials[material].textures[texture].image;
    if (!has_textures || image == IMAGE_NONE) {
        return vec4f(1.0);
    }
    let sampler = materials[material].textures[texture].sampler;
    let uv = vec3f(interpolate_uv(triangle, weights, (sampler & SAMPLER_UV1) / SAMPLER_UV1), 1.0);
    let row_u = materials[material].textures[texture].row_u;
    let row_v = materials[material].textures[texture].row_v;
    return sample_image(image, sampler, vec2f(dot(row_u, uv), dot(row_v, uv)));
}

// The texels of all textures of a material at once; white where it has none. One loop over those that are there, so
// that the code of a look-up stands in the kernel once and a material pays for its own textures only.
fn material_textures(material: u32, wanted: u32, triangle: vec4u, weights: vec3f) -> array<vec4f, FIRST_LAYER_TEXTURE> {
    var texels: array<vec4f, FIRST_LAYER_TEXTURE>;
    for (var i = 0u; i < FIRST_LAYER_TEXTURE; i++) {
        texels[i] = vec4f(1.0);
    }
    if (has_textures) {
        var mask = materials[material].texture_mask & wanted & ((1u << FIRST_LAYER_TEXTURE) - 1u);
        while (mask != 0u) {
            let texture = firstTrailingBit(mask);
            mask &= mask - 1u;
            texels[texture] = material_texture(material, texture, triangle, weights);
        }
    }
    return texels;
}

// The same for the textures of layers.
fn layer_textures(material: u32, triangle: vec4u, weights: vec3f) -> array<vec4f, LAYER_TEXTURES> {
    var texels: array<vec4f, LAYER_TEXTURES>;
    for (var i = 0u; i < LAYER_TEXTURES; i++) {
        texels[i] = vec4f(1.0);
    }
    if (has_textures) {
        var mask = materials[material].texture_mask >> FIRST_LAYER_TEXTURE;
        while (mask != 0u) {
            let layer = firstTrailingBit(mask);
            mask &= mask - 1u;
            texels[layer] = material_texture(material, FIRST_LAYER_TEXTURE + layer, triangle, weights);
        }
    }
    return texels;
}

// Base colour factor, texture and vertex colour multiplied.
fn material_base_color(material: u32, triangle: vec4u, weights: vec3f) -> vec4f {
    return materials[material].base_color
        * material_texture(material, TEXTURE_BASE_COLOR, triangle, weights)
        * interpolate_color(triangle, weights);
}

// How much of the surface is there at a point: glTF's alpha mask (0 or 1), or alpha as coverage.
fn material_coverage(material: u32, triangle: vec4u, weights: vec3f) -> f32 {
    if ((materials[material].flags & (MATERIAL_MASK | MATERIAL_BLEND)) == 0u) {
        return 1.0;
    }
    let alpha = material_base_color(material, triangle, weights).a;
    if ((materials[material].flags & MATERIAL_MASK) != 0u) {
        return select(0.0, 1.0, alpha >= materials[material].alpha_cutoff);
    }
    return alpha;
}

// Whether any material of the scene is a clear thin wall.
override has_clear: bool = true;

// What goes straight through a clear wall. `cosine` is that to the triangle: shadow rays know no other.
fn clear_transmittance(material: u32, triangle: vec4u, weights: vec3f, cosine: f32) -> vec3f {
    let f0 = materials[material].dielectric_f0 * materials[material].specular_color;
    let grazing = pow(saturate(1.0 - abs(cosine)), 5.0);
    let reflected = materials[material].specular * (f0 + (vec3f(1.0) - f0) * grazing);
    let share = materials[material].transmission
        * material_texture(material, FIRST_LAYER_TEXTURE + LAYER_TRANSMISSION, triangle, weights).x;
    let color = saturate(material_base_color(material, triangle, weights).xyz);
    return color * (vec3f(1.0) - min(reflected, vec3f(1.0))) * share;
}
