// The look's settings of ambient occlusion. The Rust twin is `procedural::AoSettings` as laid out by `wave`.

struct AoTable {
    distance: f32, // metres
    direction: u32,
    samples: u32, // 0: the table is not used
    same_object: u32, // only the hit's own instance occludes
}

const AO_OUTSIDE = 0u;
const AO_INSIDE = 1u;
const AO_BOTH = 2u; // every other ray goes inside

@group(0) @binding(33) var<uniform> ao_tables: array<AoTable, 4>;
