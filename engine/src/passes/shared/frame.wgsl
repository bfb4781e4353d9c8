// What is the same for every thread of a wave: camera, picture, and which paths the wave holds.
// The Rust twin is `frame::Frame`; a test compares the layouts.
//!include shared/hash.wgsl

struct Frame {
    camera_right: vec3f,
    width: u32,
    camera_up: vec3f,
    height: u32,
    camera_back: vec3f,
    blocks_x: u32, // blocks of 8x8 pixels in a row
    camera_position: vec3f,
    capacity: u32, // path slots of a wave, the stride of `paths`
    half_height: f32, // of the view at distance 1 (perspective), or in metres (orthographic)
    orthographic: u32,
    aperture_radius: f32,
    focus_distance: f32,
    first_pixel: u32, // padded pixel of slot 0
    first_sample: u32, // its sample
    wave_size: u32, // paths in this wave
    padded_pixels: u32, // pixels of whole blocks
    seed: u32,
    max_depth: u32, // surface vertices that may scatter
    light_count: u32, // those with a place
    environment_probability: f32, // of choosing the environment for a light sample
    environment_scale: vec3f,
    environment_turn: f32, // rotation / 360 degrees
    environment_size: vec2u, // texels of the picture
    distribution_size: vec2u, // cells of the sampling table
    bounds_center: vec3f, // a sphere around the scene
    bounds_radius: f32,
    pixel_spread: f32, // angle between neighbouring pixels, radians
    time: f32, // seconds, for textures that move
    sample_limit: u32, // samples after which no path of this job starts
    user_image_base: u32, // row of `image_table` where the images of texture arguments begin
    bounds_min: vec3f, // corners of a box around the scene
    frame_index: u32, // number of the picture, for textures that move
    bounds_max: vec3f,
    directional_count: u32,
    filter_radius: f32, // half the width of the pixel filter, pixels
    filter_positive: f32, // share of its absolute value along an axis that is positive
    filter_weight: f32, // of a sample, without its sign
    filter_is_box: u32,
    indirect_clamp: f32, // most that one contribution of indirect light adds
    estimator: u32, // see estimator.wgsl
    roulette_start: u32, // vertices that scatter before Russian roulette begins
    sampler: u32, // see random.wgsl
    aperture_blades: u32, // sides of a polygon; below 3 the aperture is a disk
    aperture_rotation: f32, // radians
    region_min: u32, // first column | first row << 16 in which paths start
    region_max: u32, // first column | first row << 16 behind these
    environment_group: u32, // of lights
    has_halves: u32, // whether samples come in two halves that know nothing of each other, see `path_id`
    lot_samples: u32, // of each pixel, where the wave's blocks are those of `lot`, not neighbours in the picture; else 0
    crop_min: u32, // column | row << 16 of the film's first pixel in the whole picture
    crop_whole: u32, // columns | rows << 16 of the whole
    crop_blocks_x: u32, // blocks in a row of the whole; 0 where the film is the whole
    sky_cell_scale: f32, // side of a cell in which the sky is known over its distance to the camera, see sky_parts.wgsl
    caches: u32, // what caches of light there are, see CACHE_
    camera_media: vec4u, // the bodies that the camera is in, see media.wgsl
    sobol: array<vec4u, 384>, // what four bits of an index add to three groups of four dimensions, see sobol.rs
    lot: array<vec4u, 2048>, // two in each: a block of the picture, and the first of the samples that it gets
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Bits of `caches`.
const CACHE_SKY = 1u; // where the sky is seen, see sky_parts.wgsl
const CACHE_IRRADIANCE = 2u; // what surfaces scatter is looked up, see irradiance/look_up.wgsl
const CACHE_GIVES = 4u; // in this wave: records are there
const CACHE_LEARNS = 8u; // in this wave: nothing is made of what the first surface scatters

// Samples of one half in a row; `film.rs` has the same number.
const HALF_RUN_BITS = 4u;

// A path slot of a wave and the sample of the picture it carries.
struct PathId {
    pixel: u32, // padded pixel index, Morton order inside blocks of 8x8
    number: u32, // of the sample
    sample: u32, // its place in the sequence of random numbers
    key: u32, // of the pixel's random numbers under this seed
}

// Where a wave has several samples of a pixel: how many slots lie between one and the next. Those of a lot are neighbours, which
// see the same and go the same way; else each sample of all pixels comes after the one before.
fn slot_stride() -> u32 {
    return select(frame.padded_pixels, 1u, frame.lot_samples != 0u);
}

// The first slot of a job of adding up, one for each pixel of the wave.
fn first_slot(job: u32) -> u32 {
    return job * max(frame.lot_samples, 1u);
}

// Behind the last one.
fn end_slot(job: u32) -> u32 {
    return select(frame.wave_size, first_slot(job + 1u), frame.lot_samples != 0u);
}

fn path_id(slot: u32) -> PathId {
    let has_lot = frame.lot_samples != 0u;
    let linear = frame.first_pixel + slot;
    let divisor = select(frame.padded_pixels, frame.lot_samples, has_lot);
    let quotient = linear / divisor;
    let rest = linear - quotient * divisor;
    var pixel = rest;
    var number = frame.first_sample + quotient;
    if (has_lot) {
        let place = quotient >> 6u;
        let two = frame.lot[place >> 1u];
        let block = select(two.xy, two.zw, (place & 1u) != 0u);
        pixel = (block.x << 6u) | (quotient & 63u);
        number = block.y + rest;
    }
    // Both are hashed: a plain `pixel ^ seed` would give another seed the same picture with its pixels swapped.
    let key = hash2(hash(number_in_whole(pixel)), frame.seed);
    if (frame.has_halves == 0u) {
        return PathId(pixel, number, number, key);
    }
    let run = number >> HALF_RUN_BITS;
    let inside = number & ((1u << HALF_RUN_BITS) - 1u);
    return PathId(pixel, number, ((run >> 1u) << HALF_RUN_BITS) | inside, hash2(key, 1u + (run & 1u)));
}

// Whether a sample is of the first half.
fn is_first_half(number: u32) -> bool {
    return ((number >> HALF_RUN_BITS) & 1u) == 0u;
}

// Every other bit of x, packed.
fn compact_bits(x: u32) -> u32 {
    var v = x & 0x55u;
    v = (v | (v >> 1u)) & 0x33u;
    v = (v | (v >> 2u)) & 0x0fu;
    return v;
}

// Column and row of a padded pixel in the film: blocks row by row, Morton order inside a block.
fn pixel_coordinates(pixel: u32) -> vec2u {
    let block = pixel >> 6u;
    let inside = pixel & 63u;
    let row = block / frame.blocks_x;
    let corner = vec2u(block - row * frame.blocks_x, row) * 8u;
    return corner + vec2u(compact_bits(inside), compact_bits(inside >> 1u));
}

// Column and row in the whole picture of what lies there in the film.
fn place_in_whole(pixel: vec2u) -> vec2u {
    return pixel + vec2u(frame.crop_min & 0xffffu, frame.crop_min >> 16u);
}

fn whole_size() -> vec2f {
    return vec2f(f32(frame.crop_whole & 0xffffu), f32(frame.crop_whole >> 16u));
}

// The opposite of `compact_bits`, of three bits.
fn spread_bits(x: u32) -> u32 {
    return (x & 1u) | ((x & 2u) << 1u) | ((x & 4u) << 2u);
}

// The padded pixel of the whole picture that a padded pixel of the film is: it has the same random numbers in both.
fn number_in_whole(pixel: u32) -> u32 {
    if (frame.crop_blocks_x == 0u) {
        return pixel;
    }
    let place = place_in_whole(pixel_coordinates(pixel));
    let block = (place.y / 8u) * frame.crop_blocks_x + place.x / 8u;
    return (block << 6u) | spread_bits(place.x & 7u) | (spread_bits(place.y & 7u) << 1u);
}

// Whether paths start in a pixel: it lies in the picture, and in the part of it that is asked for.
fn is_rendered(pixel: vec2u) -> bool {
    let low = vec2u(frame.region_min & 0xffffu, frame.region_min >> 16u);
    let high = vec2u(frame.region_max & 0xffffu, frame.region_max >> 16u);
    return all(pixel >= low) && all(pixel < min(high, vec2u(frame.width, frame.height)));
}

// Linear thread index of a dispatch that spreads its workgroups of 64 over x and y.
fn thread_index(workgroup: vec3u, workgroups: vec3u, local: u32) -> u32 {
    return (workgroup.y * workgroups.x + workgroup.x) * 64u + local;
}
