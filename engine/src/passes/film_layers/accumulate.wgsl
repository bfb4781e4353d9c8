// Adds what was recorded of the paths of a wave to the planes of a layer. One thread owns a pixel.
//!include shared/frame.wgsl
//!include shared/random.wgsl
//!include shared/filter.wgsl
//!include shared/exact_sums.wgsl
//!include film_layers/samples.wgsl
//!include film_layers/sum.wgsl
//!include film_layers/pixel.wgsl

// Of each pixel a sum of 96 bits and a spare word, or a sample's number plus 1, 0 for none, and its numbers. Ids have a
// kernel of their own.
@group(0) @binding(43) var<storage, read_write> layer_film: array<vec4u>;
// The second and third channel of a colour or a vector.
@group(0) @binding(44) var<storage, read_write> layer_film1: array<vec4u>;
@group(0) @binding(45) var<storage, read_write> layer_film2: array<vec4u>;

// A number that isn't finite would spoil its pixel for good.
fn finite_sample(word: u32, slot: u32) -> f32 {
    let value = layer_sample(word, slot);
    let is_finite = (bitcast<u32>(value) & 0x7f800000u) != 0x7f800000u;
    return select(0.0, value, is_finite);
}

// The weight that the pixel filter gives to the sample of a path.
fn sample_weight(slot: u32) -> f32 {
    if (frame.filter_positive < 1.0) {
        return filter_weight(random4(path_id(slot), DIMENSION_CAMERA, GROUP_CAMERA).xy);
    }
    return 1.0;
}

fn with_sample(words: vec4u, value: f32) -> vec4u {
    let units = fixed_point(clamp(value, -LARGEST, LARGEST), SUM_BITS);
    return vec4u(add_wide(words.xyz, units), words.w);
}

// Of one channel.
@compute @workgroup_size(64)
fn accumulate_mean(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                   @builtin(local_invocation_index) local: u32) {
    let first = thread_index(workgroup, workgroups, local);
    let at = own_pixel(first);
    if (at == NO_PIXEL) {
        return;
    }
    let end = last_slot(first);
    var words = layer_film[at];
    for (var slot = first_slot(first); slot < end; slot += slot_stride()) {
        let value = finite_sample(layer_sum.word, slot);
        if (value != 0.0 && (layer_sum.of_surfaces == 0u || layer_sample(0u, slot) != 0.0)) {
            words = with_sample(words, value * sample_weight(slot));
        }
    }
    layer_film[at] = words;
}

// Of three.
@compute @workgroup_size(64)
fn accumulate_means(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                    @builtin(local_invocation_index) local: u32) {
    let first = thread_index(workgroup, workgroups, local);
    if (first >= min(frame.wave_size, frame.padded_pixels)) {
        return;
    }
    var at = NO_PIXEL;
    var end = end_slot(first);
    var words0: vec4u;
    var words1: vec4u;
    var words2: vec4u;
    for (var slot = first_slot(first); slot < end; slot += slot_stride()) {
        if (layer_sum.lit != 0u && (lit_layers(slot) & layer_sum.lit) == 0u) {
            continue;
        }
        let value = vec3f(finite_sample(layer_sum.word, slot), finite_sample(layer_sum.word + 1u, slot),
            finite_sample(layer_sum.word + 2u, slot));
        // Most parts of the light are black most of the time: then nothing of the film is touched, nor its place worked out.
        if (all(value == vec3f(0.0)) || (layer_sum.of_surfaces != 0u && layer_sample(0u, slot) == 0.0)) {
            continue;
        }
        if (at == NO_PIXEL) {
            at = own_pixel(first);
            end = last_slot(first);
            if (at == NO_PIXEL || slot >= end) {
                return;
            }
            words0 = layer_film[at];
            words1 = layer_film1[at];
            words2 = layer_film2[at];
        }
        let weighed = value * sample_weight(slot);
        words0 = with_sample(words0, weighed.x);
        words1 = with_sample(words1, weighed.y);
        words2 = with_sample(words2, weighed.z);
    }
    if (at != NO_PIXEL) {
        layer_film[at] = words0;
        layer_film1[at] = words1;
        layer_film2[at] = words2;
    }
}

@compute @workgroup_size(64)
fn accumulate_first(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                    @builtin(local_invocation_index) local: u32) {
    let first = thread_index(workgroup, workgroups, local);
    let at = own_pixel(first);
    if (at == NO_PIXEL) {
        return;
    }
    let former = layer_film[at];
    var words = former;
    let end = last_slot(first);
    var number = own_sample(first);
    // One of before is kept.
    if (former.x != 0u && former.x <= number) {
        return;
    }
    for (var slot = first_slot(first); slot < end; slot += slot_stride()) {
        number += 1u;
        if (layer_sample(0u, slot) == 0.0 || (words.x != 0u && words.x < number)) {
            continue;
        }
        var values = vec3f(finite_sample(layer_sum.word, slot), 0.0, 0.0);
        if (layer_sum.words > 1u) {
            values.y = finite_sample(layer_sum.word + 1u, slot);
        }
        if (layer_sum.words > 2u) {
            values.z = finite_sample(layer_sum.word + 2u, slot);
        }
        words = vec4u(number, bitcast<vec3u>(values));
    }
    // Most samples are later than the first.
    if (words.x != former.x) {
        layer_film[at] = words;
    }
}
