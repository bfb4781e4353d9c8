// The texture programs' memory: a head per material, then the programs. Laid out by `procedural`.
//!include shared/outputs.wgsl

@group(0) @binding(30) var<storage, read> programs: array<u32>;

const HEAD_PROGRAM = 0u; // word offset of the program, 0: none
const HEAD_FLAGS = 1u; // see outputs.wgsl; bit 31: blend, and then bit 30: its mask is constant
const HEAD_MASK = 2u; // link word of the blend's mask
const HEAD_BASE = 3u; // material below
const HEAD_OVER = 4u; // material on top
const HEAD_AO = 5u; // bit per AO table that this material and all below its blends read
const HEAD_MASK_VALUE = 6u; // a constant mask
const HEAD_BUMP_PROGRAM = 7u; // word offset of the program that gives the height, 0: none
const HEAD_BUMP_SCALE = 8u; // metres per unit of height
const HEAD_OPACITY = 9u; // a constant opacity
const HEAD_EMISSION = 10u; // a constant emission, or the factor on a driven one
const HEAD_MORE = 13u; // the second word of driven outputs

const HEAD_IS_BLEND = 0x80000000u;
const HEAD_CONSTANT_MASK = 0x40000000u;

fn head_word(material: u32, word: u32) -> u32 {
    return programs[material * HEAD_WORDS + word];
}
