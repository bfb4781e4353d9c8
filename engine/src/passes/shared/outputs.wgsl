// What of a material a texture program can drive: bits of a head's flags and of PATH_STATE's second word. The Rust twin
// is `procedural::Output`.

const OUTPUT_BASE_COLOR = 0u;
const OUTPUT_METALLIC = 1u;
const OUTPUT_ROUGHNESS = 2u;
const OUTPUT_EMISSION = 3u;
const OUTPUT_OPACITY = 4u;
const OUTPUT_NORMAL = 5u;
const OUTPUT_SPECULAR = 6u;
const OUTPUT_SPECULAR_COLOR = 7u;
const OUTPUT_IOR = 8u;
const OUTPUT_EMISSION_STRENGTH = 9u;
const OUTPUT_NORMAL_SCALE = 10u;
const OUTPUT_TRANSMISSION = 11u;
const OUTPUT_DIFFUSE_TRANSMISSION = 12u;
const OUTPUT_DIFFUSE_TRANSMISSION_COLOR = 13u;
const OUTPUT_COAT = 14u;
const OUTPUT_COAT_ROUGHNESS = 15u;
const OUTPUT_SHEEN_COLOR = 16u;
const OUTPUT_SHEEN_ROUGHNESS = 17u;
const OUTPUT_ANISOTROPY = 18u;
const OUTPUT_ANISOTROPY_ROTATION = 19u;
const OUTPUT_IRIDESCENCE = 20u;
const OUTPUT_IRIDESCENCE_THICKNESS = 21u;
const OUTPUT_BUMP = 23u;
const OUTPUTS = 0x00ffffffu; // bits of all outputs
// Outputs of three components; those of the others have one.
const OUTPUT_VECTORS = (1u << OUTPUT_BASE_COLOR) | (1u << OUTPUT_EMISSION) | (1u << OUTPUT_NORMAL)
    | (1u << OUTPUT_SPECULAR_COLOR) | (1u << OUTPUT_DIFFUSE_TRANSMISSION_COLOR) | (1u << OUTPUT_SHEEN_COLOR)
    | (1u << OUTPUT_BUMP);
