// From the tables of `material_record`; `cargo test -p engine generated` writes it.
struct Material {
    base_color: vec4f,
    flags: u32,
    texture_mask: u32,
    light_radiance: f32,
    dielectric_f0: f32,
    alpha_cutoff: f32,
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    emission: vec3f,
    specular: f32,
    specular_color: vec3f,
    ior: f32,
    transmission: f32,
    dispersion: f32,
    priority: f32,
    diffuse_transmission: f32,
    diffuse_transmission_color: vec3f,
    coat: f32,
    coat_roughness: f32,
    sheen_roughness: f32,
    anisotropy: f32,
    anisotropy_rotation: f32,
    sheen_color: vec3f,
    iridescence: f32,
    iridescence_ior: f32,
    coat_normal_scale: f32,
    iridescence_thickness: vec2f,
    absorption: vec3f,
    id: u32,
    textures: array<TextureSlot, 17>,
}
const MATERIAL_DOUBLE_SIDED = 1u;
const MATERIAL_UNLIT = 2u;
const MATERIAL_MASK = 4u;
const MATERIAL_BLEND = 8u;
const MATERIAL_PROGRAM = 16u;
const MATERIAL_PROGRAM_LAST = 32u;
const MATERIAL_PROGRAM_LIGHT = 64u;
const MATERIAL_SOLID = 128u;
const MATERIAL_CLEAR = 256u;
const MATERIAL_SHADOW_CATCHER = 512u;
const MATERIAL_CASTER = 1024u;
const MATERIAL_LIGHT_GROUP_SHIFT = 28u;
const TEXTURE_BASE_COLOR = 0u;
const TEXTURE_METALLIC_ROUGHNESS = 1u;
const TEXTURE_NORMAL = 2u;
const TEXTURE_EMISSION = 3u;
const TEXTURE_SPECULAR = 4u;
const TEXTURE_SPECULAR_COLOR = 5u;
// The textures of layers begin here; their numbers are relative to it.
const FIRST_LAYER_TEXTURE = 6u;
const LAYER_TEXTURES = 11u;
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
