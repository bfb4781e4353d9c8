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
const OUTPUT_BUMP = 23u;
const OUTPUTS = 0x00ffffffu; // bits of all outputs
// Outputs of three components; those of the others have one.
const OUTPUT_VECTORS = (1u << OUTPUT_BASE_COLOR) | (1u << OUTPUT_EMISSION) | (1u << OUTPUT_NORMAL)
    | (1u << OUTPUT_SPECULAR_COLOR) | (1u << OUTPUT_BUMP);
