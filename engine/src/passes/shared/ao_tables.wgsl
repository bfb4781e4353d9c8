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

// Whether one thread traces all rays of a hit, or each thread one.
override ao_thread_per_hit: bool = false;

// Threads that a hit's rays need.
fn ao_threads() -> u32 {
    if (ao_thread_per_hit) {
        return 1u;
    }
    var samples = 1u;
    for (var i = 0u; i < 4u; i++) {
        samples = max(samples, ao_tables[i].samples);
    }
    return samples;
}
