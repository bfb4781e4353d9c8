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

// Most ids of a pixel; `film/ids.rs` has the same number.
const IDS = 8u;

@compute @workgroup_size(64)
fn accumulate_ids(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                  @builtin(local_invocation_index) local: u32) {
    let first = thread_index(workgroup, workgroups, local);
    let at = own_pixel(first);
    if (at == NO_PIXEL) {
        return;
    }
    let a = layer_film[at];
    let b = layer_film1[at];
    let c = layer_film2[at];
    let d = layer_film3[at];
    var counts = array<vec2u, IDS>(a.xy, a.zw, b.xy, b.zw, c.xy, c.zw, d.xy, d.zw);
    let end = last_slot(first);
    for (var slot = first; slot < end; slot += frame.padded_pixels) {
        if (layer_sample(0u, slot) == 0.0) {
            continue;
        }
        // Moves what is larger up by one. What finds no room is dropped: the largest.
        var carried = vec2u(bitcast<u32>(layer_sample(layer_sum.word, slot)), 1u);
        for (var i = 0u; i < IDS && carried.x != 0u; i += 1u) {
            let here = counts[i];
            if (here.x == carried.x) {
                counts[i].y = here.y + carried.y;
                carried = vec2u(0u);
            } else if (here.x == 0u || carried.x < here.x) {
                counts[i] = carried;
                carried = here;
            }
        }
    }
    layer_film[at] = vec4u(counts[0], counts[1]);
    layer_film1[at] = vec4u(counts[2], counts[3]);
    layer_film2[at] = vec4u(counts[4], counts[5]);
    layer_film3[at] = vec4u(counts[6], counts[7]);
}
