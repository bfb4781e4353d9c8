// The film: the sum and the sum of squares of each pixel's samples. `entry.wgsl` is the pass. The sums are fixed-point
// numbers of 96 bits, so they are exact whatever the order: see `film.rs`, which has the twin of the arithmetic.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/queues.wgsl
//!include shared/random.wgsl
//!include shared/filter.wgsl
//!include shared/exact_sums.wgsl

// Twenty words per pixel: the sums of red, green and blue, of their squares, the number of samples, and where these come in
// halves, the number of those in the first one, whose sums take the place of the squares.
// Five buffers, because a device need not bind more than 128 MiB of one.
@group(0) @binding(5) var<storage, read_write> film0: array<vec4u>;
@group(0) @binding(6) var<storage, read_write> film1: array<vec4u>;
@group(0) @binding(7) var<storage, read_write> film2: array<vec4u>;
@group(0) @binding(8) var<storage, read_write> film3: array<vec4u>;
@group(0) @binding(9) var<storage, read_write> film4: array<vec4u>;

// The same of the sums of squares as of the others.
const SQUARE_BITS = 36;
const LARGEST_SQUARE = 1099511562240.0;

// Bits of 1e30 and of -0: samples beyond the one are no samples, nor are negative ones.
const LARGEST_BITS = 0x7149f2cau;
const MINUS_ZERO = 0x80000000u;

// What a pixel has gathered.
struct Sums {
    red: vec3u,
    green: vec3u,
    blue: vec3u,
    red_squares: vec3u,
    green_squares: vec3u,
    blue_squares: vec3u,
    count: u32,
    first_half: u32,
}

fn sums_read(at: u32) -> Sums {
    let words0 = film0[at];
    let words1 = film1[at];
    let words2 = film2[at];
    let words3 = film3[at];
    let words4 = film4[at];
    return Sums(words0.xyz, vec3u(words0.w, words1.xy), vec3u(words1.zw, words2.x), words2.yzw, words3.xyz,
        vec3u(words3.w, words4.xy), words4.z, words4.w);
}

fn sums_write(at: u32, sums: Sums) {
    film0[at] = vec4u(sums.red, sums.green.x);
    film1[at] = vec4u(sums.green.yz, sums.blue.xy);
    film2[at] = vec4u(sums.blue.z, sums.red_squares);
    film3[at] = vec4u(sums.green_squares, sums.blue_squares.x);
    film4[at] = vec4u(sums.blue_squares.yz, sums.count, sums.first_half);
}

// Adds the sample of a finished path.
fn add_sample(sums: ptr<function, Sums>, slot: u32) {
    var value = path_read(PATH_RADIANCE, slot).xyz;
    // Unless the shadow ray met more surfaces than anyone waits for.
    let is_known = !has_program_shadows || path_words(PATH_LIGHT_POINT, slot).x == MISS;
    if (rays[shadow_ray(slot)].triangle == MISS && is_known) {
        // The path ended where it sampled this light, before that vertex was counted.
        value += waiting_light(slot, path_depth(slot) + 1u);
    }
    // A sample that isn't finite would spoil its pixel for good. Its bits tell, as whole numbers: compilers may assume that
    // there is no NaN.
    let bits = bitcast<vec3u>(value);
    if (!all((bits <= vec3u(LARGEST_BITS)) | (bits == vec3u(MINUS_ZERO)))) {
        value = vec3f(0.0);
        atomicAdd(&queues[WORD_INVALID], 1u);
    }
    if (frame.filter_positive < 1.0) {
        value *= filter_weight(random4(path_id(slot), DIMENSION_CAMERA, GROUP_CAMERA).xy);
    }
    if (any(abs(value) > vec3f(LARGEST))) {
        value = clamp(value, vec3f(-LARGEST), vec3f(LARGEST));
        atomicAdd(&queues[WORD_CLAMPED], 1u);
    }
    let red = fixed_point(value.x, SUM_BITS);
    let green = fixed_point(value.y, SUM_BITS);
    let blue = fixed_point(value.z, SUM_BITS);
    (*sums).red = add_wide((*sums).red, red);
    (*sums).green = add_wide((*sums).green, green);
    (*sums).blue = add_wide((*sums).blue, blue);
    (*sums).count += 1u;
    if (frame.has_halves == 0u) {
        let square = min(value * value, vec3f(LARGEST_SQUARE));
        (*sums).red_squares = add_wide((*sums).red_squares, fixed_point(square.x, SQUARE_BITS));
        (*sums).green_squares = add_wide((*sums).green_squares, fixed_point(square.y, SQUARE_BITS));
        (*sums).blue_squares = add_wide((*sums).blue_squares, fixed_point(square.z, SQUARE_BITS));
    } else if (is_first_half(path_id(slot).number)) {
        (*sums).red_squares = add_wide((*sums).red_squares, red);
        (*sums).green_squares = add_wide((*sums).green_squares, green);
        (*sums).blue_squares = add_wide((*sums).blue_squares, blue);
        (*sums).first_half += 1u;
    }
}
