// Photons as they lie in memory: a header of four words, the first of them how many there are; then eight words each: position,
// octahedral normal of the side that they met; flux in red, green and blue, as whole numbers so that sums don't depend on the
// order; and how many casters have scattered them, with some bits of the hash of their cell of the grid above.
//!include photons/settings.wgsl
//!include shared/frame.wgsl
//!include shared/vectors.wgsl
//!include shared/hash.wgsl

// How far a place may lie above or below a photon's own surface, over the radius.
const MOST_HEIGHT = 0.25;

const PHOTON_WORDS = 8u;

// Flux of 1, which is what a photon has on average. Lamps are chosen by their luminance, of which pure blue has least: 13.9 for each of a
// million photons, all of them at one place, still go into 32 bits.
const FLUX_SCALE = 256.0;

// How far photons count at a place: a share of the distance, since pixels are as much wider.
fn photon_radius(place: vec3f) -> f32 {
    if (frame.orthographic != 0u) {
        return photon_settings.radius;
    }
    return photon_settings.radius * max(length(place - frame.camera_position), photon_settings.nearest);
}

const PHOTON_SCATTERED = 0xffu;
const PHOTON_CHECK_SHIFT = 8u;

// Whether photons are looked up in the grid that they are sorted by, or in an octree of references. A processor has the grid in no
// time, and reads what lies side by side fast; threads of a graphics card should all do the same at once, as they do in one leaf.
override photons_by_grid: bool = false;

// Side of a cell of the grid over the radius there, at most; at least half of it.
const GRID_SIDE = 3.0;

// The cell of the grid around a place that photons reach `radius` of. As levels below, cells of two sizes may meet.
fn grid_level(radius: f32) -> u32 {
    return bitcast<u32>(GRID_SIDE * radius) >> 23u;
}

// Two words for each cell: where its photons begin, and how many there are. Before them as many, the first of them the number of
// photons that have a place.
fn grid_cell(level: u32, cell: vec3i) -> MapCell {
    let number = hash_of_cell(level, cell);
    return MapCell(number & photon_settings.cell_mask, hash(number) >> PHOTON_CHECK_SHIFT);
}

// The map is an octree whose nodes are found by a hash, and whose leaves know all photons that reach into them: a place asks one
// leaf alone (after Frolov et al., "Multiple reference octrees for a GPU photon mapping and irradiance caching", 2014). Its roots
// are cells of a grid, wide as what photons reach there; next to each other there may be roots of two sizes.
// Four words for each cell: references while they are counted, or put down; whether it is split; the first; how many.
// Cells that share a place by their hash share all that: references say whose they are.

// Levels below the roots: finer leaves hold less that is not asked for, but each photon is in more of them.
const MAP_DEPTH = 1u;
// A leaf of more references is split the next time.
const LEAF_MOST = 96u;

// A reference is a photon's number below, and some bits of its cell's hash above.
const REFERENCE_PHOTON = 0xfffffu;
const REFERENCE_SHIFT = 20u;

struct MapCell {
    at: u32, // place in the map
    check: u32, // bits that tell it from others there
}

// The exponent of the side of the roots around a place that photons reach `radius` of: the next power of two above one and a half
// of it, so that a disk is in five roots at most on a plane along the cells, and in thirteen of their children.
fn root_level(radius: f32) -> u32 {
    return (bitcast<u32>(1.5 * radius) >> 23u) + 1u;
}

fn side_of(level: u32) -> f32 {
    return bitcast<f32>(level << 23u);
}

fn hash_of_cell(kind: u32, cell: vec3i) -> u32 {
    let place = vec3u(bitcast<u32>(cell.x), bitcast<u32>(cell.y), bitcast<u32>(cell.z));
    return hash2(hash2(hash2(hash(kind), place.x), place.y), place.z);
}

fn map_cell(root: u32, depth: u32, cell: vec3i) -> MapCell {
    let number = hash_of_cell(4u * root + depth, cell);
    return MapCell(number & photon_settings.cell_mask, hash(number) >> REFERENCE_SHIFT);
}
