// Counts the samples of a wave by what they met, in the planes of a layer of ids. One thread owns a pixel.
//!include shared/frame.wgsl
//!include film_layers/samples.wgsl
//!include film_layers/sum.wgsl
//!include film_layers/pixel.wgsl

// Two ids and their numbers of samples each, ascending from the first to the last plane; 0 where there is none.
@group(0) @binding(43) var<storage, read_write> layer_film: array<vec4u>;
@group(0) @binding(44) var<storage, read_write> layer_film1: array<vec4u>;
@group(0) @binding(45) var<storage, read_write> layer_film2: array<vec4u>;
@group(0) @binding(46) var<storage, read_write> layer_film3: array<vec4u>;

// Two places, and what is to be counted behind them; id 0 is nothing.
struct Counted {
    places: vec4u,
    carried: vec2u,
}

// Moves what is larger up by one.
fn counted(places: vec4u, sample: vec2u) -> Counted {
    var counts = Counted(places, sample);
    if (counts.places.x == counts.carried.x) {
        counts.places.y += counts.carried.y;
        counts.carried = vec2u(0u);
    } else if (counts.places.x == 0u || counts.carried.x < counts.places.x) {
        counts = Counted(vec4u(counts.carried, counts.places.zw), counts.places.xy);
    }
    if (counts.carried.x == 0u) {
        return counts;
    }
    if (counts.places.z == counts.carried.x) {
        counts.places.w += counts.carried.y;
        counts.carried = vec2u(0u);
    } else if (counts.places.z == 0u || counts.carried.x < counts.places.z) {
        counts = Counted(vec4u(counts.places.xy, counts.carried), counts.places.zw);
    }
    return counts;
}

// What finds no room in any plane is dropped: the largest. Most pixels see few objects, and only their first planes are touched.
fn count_sample(at: u32, id: u32) {
    var counts = counted(layer_film[at], vec2u(id, 1u));
    layer_film[at] = counts.places;
    if (counts.carried.x == 0u) {
        return;
    }
    counts = counted(layer_film1[at], counts.carried);
    layer_film1[at] = counts.places;
    if (counts.carried.x == 0u) {
        return;
    }
    counts = counted(layer_film2[at], counts.carried);
    layer_film2[at] = counts.places;
    if (counts.carried.x == 0u) {
        return;
    }
    counts = counted(layer_film3[at], counts.carried);
    layer_film3[at] = counts.places;
}

@compute @workgroup_size(64)
fn accumulate_ids(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                  @builtin(local_invocation_index) local: u32) {
    let first = thread_index(workgroup, workgroups, local);
    let at = own_pixel(first);
    if (at == NO_PIXEL) {
        return;
    }
    let end = last_slot(first);
    for (var slot = first_slot(first); slot < end; slot += slot_stride()) {
        let id = bitcast<u32>(layer_sample(layer_sum.word, slot));
        if (id != 0u && layer_sample(0u, slot) != 0.0) {
            count_sample(at, id);
        }
    }
}
