// A cache of the light that surfaces scatter, in cells of a grid over the scene that a hash finds (Binder et al., "Massively Parallel
// Path Space Filtering", arXiv 1902.05942, 2019). A cell knows the mean of what paths have found that went on
// from inside it.
//!include shared/frame.wgsl
//!include shared/hash.wgsl
//!include shared/exact_sums.wgsl
//!include shared/powers.wgsl

// The Rust twin is `renderer::light_cache::Settings`.
struct LightCacheSettings {
    mode: u32,
    mask: u32, // cells less one: a power of two
    record: u32, // field of a path's state where its record begins
    least_count: u32, // paths that must have gone on from a cell before it is believed
    scale: f32, // side of a cell over its distance to the camera
    least_side: f32, // metres
    photons: u32, // field of a path's state that is the photons' own, 0 where there are none
    lesser: u32, // words from a cell to what it knows of light that goes on once less
    ends: u32, // while the cache learns: whether paths end in what it knows of such light, or go on to their end
    begins: u32, // while the cache learns: of 2^32 paths how many begin cells that aren't there, or all
    half: u32, // to which half of all that is known of the light paths belong
    unused: u32,
}

// What is known of the light comes in halves that know nothing of each other, where the picture's samples do, each with cells of its own. To which
// a path belongs: to this,
const HALF_ONE = 0u;
const HALF_OTHER = 1u;
// to that of its sample,
const HALF_OF_SAMPLE = 2u;
// or, of neighbouring pixels, and of samples of a pixel, by turns to one and to the other.
const HALF_BY_TURNS = 3u;

// Paths go on, and are learned from.
const LIGHT_CACHE_LEARNS = 1u;
// Paths end in the cache.
const LIGHT_CACHE_ENDS = 0u;
// Paths go on.
const LIGHT_CACHE_IDLE = 2u;

@group(0) @binding(49) var<uniform> light_cache_settings: LightCacheSettings;

// Eight words for each cell: a number by which it is known, or 0 where it is free; how many paths have gone on from it; three
// sums of 64 bits, in units of 2^-24. Behind all of them as many words follow, in which paths end that are learned from: for each cell the same
// count and sums, of paths that went on to their end, without what they found after they had scattered as often as they may. A path
// that ends there has scattered once more than those had when they came to the cell.
@group(0) @binding(48) var<storage, read_write> light_cache: array<atomic<u32>>;

const CELL_WORDS = 8u;
const CELL_COUNT = 1u;
const CELL_SUMS = 2u;
const CELL_BITS = 24;
const LARGEST_CELL_SAMPLE = 16777216.0;
// Places that are looked at for a cell, farther and farther apart: side by side they would fill up in long runs, and a cell whose run is too
// long has room or not by which came first. So few are only reached where nearly all places are taken.
const CELL_PROBES = 128u;
const NO_CELL = 0xffffffffu;

// The side of the cells at a point: a power of two that grows with the distance to the camera.
fn cell_side(position: vec3f) -> f32 {
    let wanted = max(distance(position, frame.camera_position) * light_cache_settings.scale, light_cache_settings.least_side);
    return power_of_two_below(wanted);
}

// Steps from the middle by which cells tell apart whereto a surface scatters that doesn't scatter the same all around: some 15 degrees. What a
// table with a roughness of 0.45 reflects of the sun is hardly 30 wide.
const VIEW_STEPS = 4.0;

// The first word of the cell for a point of a surface that scatters to `view`, which is 0 where it doesn't matter, or NO_CELL where
// there is none. A cell that isn't there is begun where that is wanted and there is room.
fn cell_at(position: vec3f, normal: vec3f, view: vec3f, side: f32, half: u32, begins: bool) -> u32 {
    let place = vec3i(floor(position / side));
    // Surfaces of other directions have cells of their own, thin walls one on each side.
    let toward = vec3i(round(normal * 2.0)) + 2;
    let seen_from = vec3i(round(view * VIEW_STEPS)) + i32(VIEW_STEPS);
    let direction = u32(toward.x + 5 * toward.y + 25 * toward.z + 125 * (seen_from.x + 9 * seen_from.y + 81 * seen_from.z));
    let known_by = hash2(hash2(hash2(bitcast<u32>(place.x), bitcast<u32>(place.y)), bitcast<u32>(place.z)),
        hash2(direction + (half << 20u), bitcast<u32>(side)));
    let number = max(hash(known_by ^ 0x5bd1e995u), 1u);
    for (var i = 0u; i < CELL_PROBES; i++) {
        let cell = ((known_by + i * (i + 1u) / 2u) & light_cache_settings.mask) * CELL_WORDS;
        var found = atomicLoad(&light_cache[cell]);
        if (found == 0u && begins) {
            let former = atomicCompareExchangeWeak(&light_cache[cell], 0u, number);
            if (former.exchanged) {
                return cell;
            }
            // Another thread was there first, or the exchange failed for no reason: what is there now says which.
            found = atomicLoad(&light_cache[cell]);
            if (found == 0u) {
                i--;
                continue;
            }
        }
        if (found == number) {
            return cell;
        }
        if (found == 0u) {
            return NO_CELL;
        }
    }
    return NO_CELL;
}

// What surfaces scatter from a cell on average, and in w how many paths have said so. `lesser`: 0, or words to what is known of light that
// goes on once less.
fn cell_mean(begins_at: u32, lesser: u32) -> vec4f {
    if (begins_at == NO_CELL) {
        return vec4f(0.0);
    }
    let cell = begins_at + lesser;
    let count = atomicLoad(&light_cache[cell + CELL_COUNT]);
    var sums = vec3f(0.0);
    for (var i = 0u; i < 3u; i++) {
        let low = f32(atomicLoad(&light_cache[cell + CELL_SUMS + 2u * i]));
        let high = f32(atomicLoad(&light_cache[cell + CELL_SUMS + 2u * i + 1u]));
        sums[i] = fma(high, 4294967296.0, low);
    }
    return vec4f(sums * (power_of_two(-CELL_BITS) / f32(max(count, 1u))), f32(count));
}

fn cell_add(cell: u32, value: vec3f) {
    let clamped = clamp(value, vec3f(0.0), vec3f(LARGEST_CELL_SAMPLE));
    atomicAdd(&light_cache[cell + CELL_COUNT], 1u);
    for (var i = 0u; i < 3u; i++) {
        let units = fixed_point(clamped[i], CELL_BITS);
        let before = atomicAdd(&light_cache[cell + CELL_SUMS + 2u * i], units.x);
        let high = units.y + u32(before + units.x < before);
        if (high != 0u) {
            atomicAdd(&light_cache[cell + CELL_SUMS + 2u * i + 1u], high);
        }
    }
}

const ALL_BEGIN = 0xffffffffu;

// Whether a path begins cells that aren't there.
fn begins_cells(path: PathId) -> bool {
    let begins = light_cache_settings.begins;
    return begins == ALL_BEGIN || hash2(path.key, path.number ^ 0x2545f491u) < begins;
}

// To which half of what is known a path belongs.
fn half_of(path: PathId) -> u32 {
    let half = light_cache_settings.half;
    if (half == HALF_OF_SAMPLE) {
        return u32(!is_first_half(path.number));
    }
    if (half == HALF_BY_TURNS) {
        return (path.number ^ path.pixel ^ (path.pixel >> 1u)) & 1u;
    }
    return half;
}

// Of a path that is learned from: its cell, or NO_CELL, and its throughput there; what it had gathered before, and whether all of this
// is known yet.
const RECORD_NONE = 0u;
const RECORD_BEGUN = 1u;
const RECORD_KNOWN = 2u;
const RECORD_DEEP = 3u; // known, and the path has scattered as often as it may: the cell has been told what it had found before
