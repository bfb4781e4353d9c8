// Materials in memory. The Rust twin is `gpu_scene::materials::GpuMaterial`; a test compares the layouts.

struct TextureSlot {
    row_u: vec3f, // u' = dot(row_u, (u, v, 1))
    image: u32, // IMAGE_NONE: no texture
    row_v: vec3f,
    sampler: u32,
}

struct Material {
    base_color: vec4f,
    emission: vec3f,
    light_radiance: f32, // mean radiance by which triangles are in the table of lights; 0: they are not
    specular_color: vec3f,
    specular: f32,
    metallic: f32,
    roughness: f32,
    dielectric_f0: f32,
    alpha_cutoff: f32,
    normal_scale: f32,
    flags: u32,
    texture_mask: u32, // bit per texture that is there
    ior: f32,
    absorption: vec3f, // 1/metres
    transmission: f32,
    diffuse_transmission_color: vec3f,
    diffuse_transmission: f32,
    sheen_color: vec3f,
    sheen_roughness: f32,
    coat: f32,
    coat_roughness: f32,
    coat_normal_scale: f32,
    iridescence: f32,
    anisotropy: f32,
    anisotropy_rotation: f32, // radians
    iridescence_ior: f32,
    dispersion: f32, // 20 / Abbe number
    iridescence_thickness: vec2f, // nanometres
    priority: f32, // of a body among bodies that overlap
    spare: f32,
    textures: array<TextureSlot, 17>,
}

const TEXTURE_BASE_COLOR = 0u;
const TEXTURE_METALLIC_ROUGHNESS = 1u;
const TEXTURE_NORMAL = 2u;
const TEXTURE_EMISSION = 3u;
const TEXTURE_SPECULAR = 4u;
const TEXTURE_SPECULAR_COLOR = 5u;
// The textures of layers begin here; their numbers are relative to it.
const FIRST_LAYER_TEXTURE = 6u;
const LAYER_TRANSMISSION = 0u;
const LAYER_DIFFUSE_TRANSMISSION = 1u;
const LAYER_DIFFUSE_TRANSMISSION_COLOR = 2u;
const LAYER_SHEEN_COLOR = 3u;
const LAYER_SHEEN_ROUGHNESS = 4u;
const LAYER_COAT = 5u;
const LAYER_COAT_ROUGHNESS = 6u;
const LAYER_COAT_NORMAL = 7u;
const LAYER_ANISOTROPY = 8u;
const LAYER_IRIDESCENCE = 9u;
const LAYER_IRIDESCENCE_THICKNESS = 10u;

const MATERIAL_DOUBLE_SIDED = 1u;
const MATERIAL_UNLIT = 2u;
const MATERIAL_MASK = 4u;
const MATERIAL_BLEND = 8u;
const MATERIAL_PROGRAM = 16u; // has a head in the texture programs
const MATERIAL_PROGRAM_LAST = 32u; // and needs it to know how much light comes out of it: emission, opacity
const MATERIAL_SOLID = 128u; // bounds a body
const MATERIAL_CLEAR = 256u; // a thin wall that light goes through straight on, so that shadow rays can follow it
const MATERIAL_PROGRAM_LIGHT = 64u; // and is sampled as a light, whose emission the program tells

@group(0) @binding(14) var<storage, read> materials: array<Material>;

// Whether any material of the scene has a texture program.
override has_programs: bool = true;

// Whether the texture program runs for a hit of this material: after the last scattering only emission matters.
fn runs_program(flags: u32, depth: u32) -> bool {
    return has_programs && (flags & select(MATERIAL_PROGRAM, MATERIAL_PROGRAM_LAST, depth >= frame.max_depth)) != 0u;
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
fn material_textures(material: u32, wanted: u32, triangle: vec4u, weights: vec3f) -> array<vec4f, 6> {
    var texels: array<vec4f, 6>;
    for (var i = 0u; i < 6u; i++) {
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
fn layer_textures(material: u32, triangle: vec4u, weights: vec3f) -> array<vec4f, 11> {
    var texels: array<vec4f, 11>;
    for (var i = 0u; i < 11u; i++) {
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
