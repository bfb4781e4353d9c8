// The grid that finds records of irradiance by where they are: cells of several levels. Those of a block of 2x2x2 stand near each other,
// so that neighbours are found near each other, too. `renderer/irradiance/grid.rs` makes it.
//!include irradiance/records.wgsl
//!include shared/hash.wgsl

// A hash leads to a cell's slot: a number by which its block is known, or 0 where the slot is free; its first reference, and how many;
// its coordinates as far as they fit.
@group(0) @binding(52) var<storage, read> irradiance_grid: array<vec4u>;
// Records that reach into a cell:
//  x, y: position, from the corner of the cell before, over three sides; how far it reaches, over one side; 16 bits each
//  z: normal, 10 bits for each coordinate
//  w: which record, 24 bits, and of what it says how much is left to paths, 8 bits
@group(0) @binding(53) var<storage, read> irradiance_references: array<vec4u>;

// Slots that are looked at for a cell.
const GRID_PROBES = 64u;
// Cells of a block, whose slots stand together.
const GRID_BLOCK = 8u;
// Of a normal's coordinates, from 0 to 1.
const COARSE_STEPS = 511.0;

// First reference of a cell, and behind its last.
fn references_of(cell: vec3i, level: u32) -> vec2u {
    let block = bitcast<vec3u>(cell >> vec3u(1u)) * vec3u(0x8da6b343u, 0xd8163841u, 0xcb1ab31fu);
    let number = hash(block.x ^ block.y ^ block.z ^ (level * 0x9e3779b9u));
    let known_by = max(number, 1u);
    let place = bitcast<vec3u>(cell);
    let odd = place & vec3u(1u);
    let low = place & vec3u(0x3ffu);
    let check = low.x | (low.y << 10u) | (low.z << 20u) | (level << 30u);
    let first = (number & ~(GRID_BLOCK - 1u)) | ((odd.x | (odd.y << 1u) | (odd.z << 2u)) ^ (number >> 29u));
    for (var i = 0u; i < GRID_PROBES; i++) {
        let slot = irradiance_grid[(first + GRID_BLOCK * i) & irradiance_settings.mask];
        if (slot.x == known_by && slot.w == check) {
            return vec2u(slot.y, slot.y + slot.z);
        }
        if (slot.x == 0u) {
            break;
        }
    }
    return vec2u(0u);
}

// Where a record lies, from the corner of the cell that refers to it, in sides of that.
fn reference_place(reference: vec4u) -> vec3f {
    return 3.0 * vec3f(unpack2x16unorm(reference.x), unpack2x16unorm(reference.y).x) - vec3f(1.0);
}

// How far it reaches, likewise.
fn reference_reach(reference: vec4u) -> f32 {
    return unpack2x16unorm(reference.y).y;
}

// Where its record begins.
fn reference_record(reference: vec4u) -> u32 {
    return (reference.w & 0xffffffu) * RECORD_WORDS;
}

// How much of what it says is left to paths.
fn reference_left(reference: vec4u) -> f32 {
    return f32(reference.w >> 24u) / 255.0;
}

// Its normal.
fn reference_facing(reference: vec4u) -> vec3f {
    let words = (vec3u(reference.z) >> vec3u(0u, 10u, 20u)) & vec3u(0x3ffu);
    return (vec3f(words) - vec3f(COARSE_STEPS + 1.0)) / COARSE_STEPS;
}

// A normal as references have it.
fn coarse_normal(normal: vec3f) -> vec3f {
    return round(normal * COARSE_STEPS) / COARSE_STEPS;
}
