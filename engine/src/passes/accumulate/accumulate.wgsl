// Adds the finished paths of a wave to the film: the sum and the sum of squares of each pixel's samples.
// One thread owns a pixel. The sums are fixed-point numbers of 96 bits, so they are exact whatever the order: see
// `film.rs`, which has the twin of the arithmetic.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/queues.wgsl
//!include shared/random.wgsl
//!include shared/filter.wgsl

// Twenty words per pixel: the sums of red, green and blue, of their squares, the number of samples, one to spare.
// Five buffers, because a device need not bind more than 128 MiB of one.
@group(0) @binding(5) var<storage, read_write> film0: array<vec4u>;
@group(0) @binding(6) var<storage, read_write> film1: array<vec4u>;
@group(0) @binding(7) var<storage, read_write> film2: array<vec4u>;
@group(0) @binding(8) var<storage, read_write> film3: array<vec4u>;
@group(0) @binding(9) var<storage, read_write> film4: array<vec4u>;

// Bits behind the point, and the largest values that leave room for 2^20 samples.
const SUM_BITS = 44;
const SQUARE_BITS = 36;
const LARGEST = 2147483520.0;
const LARGEST_SQUARE = 1099511562240.0;

// Sum of two numbers of 96 bits, modulo 2^96; the least significant word first.
fn add_wide(a: vec3u, b: vec3u) -> vec3u {
    let low = a.x + b.x;
    let middle = a.y + b.y;
    let carried = middle + u32(low < a.x);
    return vec3u(low, carried, a.z + b.z + u32(middle < a.y) + u32(carried < middle));
}

// A number below 2^(95 - bits) as a whole number of units of 2^-bits, rounded to nearest, as two's complement.
fn fixed_point(value: f32, bits: i32) -> vec3u {
    let word = bitcast<u32>(value);
    let mantissa = (word & 0x7fffffu) | 0x800000u;
    let shift = i32((word >> 23u) & 255u) - 150 + bits;
    var whole = vec3u(0u);
    if (shift >= 0) {
        let bit = u32(shift) & 31u;
        let low = mantissa << bit;
        let high = (mantissa >> 1u) >> (31u - bit); // without a shift by 32
        switch shift >> 5u {
            case 0: { whole = vec3u(low, high, 0u); }
            case 1: { whole = vec3u(0u, low, high); }
            default: { whole = vec3u(0u, 0u, low); }
        }
    } else if (shift >= -24) {
        let right = u32(-shift);
        whole.x = (mantissa + (1u << (right - 1u))) >> right;
    }
    if (value < 0.0) {
        whole = add_wide(~whole, vec3u(1u, 0u, 0u));
    }
    return whole;
}

@compute @workgroup_size(64)
fn accumulate(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
              @builtin(local_invocation_index) local: u32) {
    let first = thread_index(workgroup, workgroups, local);
    if (first >= min(frame.wave_size, frame.padded_pixels)) {
        return;
    }
    let pixel = pixel_coordinates(path_id(first).pixel);
    if (!is_rendered(pixel)) {
        return;
    }
    let at = pixel.y * frame.width + pixel.x;
    let words0 = film0[at];
    let words1 = film1[at];
    let words2 = film2[at];
    let words3 = film3[at];
    let words4 = film4[at];
    var red = words0.xyz;
    var green = vec3u(words0.w, words1.xy);
    var blue = vec3u(words1.zw, words2.x);
    var red_squares = words2.yzw;
    var green_squares = words3.xyz;
    var blue_squares = vec3u(words3.w, words4.xy);
    var count = words4.z;
    for (var slot = first; slot < frame.wave_size; slot += frame.padded_pixels) {
        if (path_id(slot).sample >= frame.sample_limit) {
            break;
        }
        var value = path_read(PATH_RADIANCE, slot).xyz;
        // Unless the shadow ray met more surfaces than anyone waits for.
        let is_known = !has_program_shadows || path_words(PATH_LIGHT_POINT, slot).x == MISS;
        if (rays[frame.capacity + slot].triangle == MISS && is_known) {
            // The path ended where it sampled this light, before that vertex was counted.
            value += waiting_light(slot, path_depth(slot) + 1u);
        }
        // A sample that isn't finite would spoil its pixel for good. Comparisons with NaN are false.
        if (!(all(value >= vec3f(0.0)) && all(value <= vec3f(1e30)))) {
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
        let square = min(value * value, vec3f(LARGEST_SQUARE));
        red = add_wide(red, fixed_point(value.x, SUM_BITS));
        green = add_wide(green, fixed_point(value.y, SUM_BITS));
        blue = add_wide(blue, fixed_point(value.z, SUM_BITS));
        red_squares = add_wide(red_squares, fixed_point(square.x, SQUARE_BITS));
        green_squares = add_wide(green_squares, fixed_point(square.y, SQUARE_BITS));
        blue_squares = add_wide(blue_squares, fixed_point(square.z, SQUARE_BITS));
        count += 1u;
    }
    film0[at] = vec4u(red, green.x);
    film1[at] = vec4u(green.yz, blue.xy);
    film2[at] = vec4u(blue.z, red_squares);
    film3[at] = vec4u(green_squares, blue_squares.x);
    film4[at] = vec4u(blue_squares.yz, count, 0u);
}
