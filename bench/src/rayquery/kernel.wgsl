// A whole path tracer in one kernel: a thread takes a path from the camera to the film, and all that the passes do stands
// in its loop. `textured.wgsl` and `plain.wgsl` include this file with and without texture programs.
//!include rayquery/path_memory.wgsl
//!include rayquery/queries.wgsl
//!include raygen/raygen.wgsl
//!include traverse/traverse.wgsl
//!include brdf/brdf.wgsl
//!include accumulate/accumulate.wgsl

// Surfaces that a path may pass without being scattered: as many as the renderer waits for.
const MOST_PASSAGES = 2048u;

// A path from its start to its end; the order of the steps is that of a wave.
fn trace_path(slot: u32) {
    goes_on = false;
    shadow_waits = false;
    start_path(slot);
    for (var round = 0u; goes_on && round <= frame.max_depth + MOST_PASSAGES; round++) {
        find_closest(slot);
        run_programs(slot);
        goes_on = false;
        shade_vertex(slot);
        if (shadow_waits) {
            shadow_waits = false;
            find_occluder(slot);
        }
    }
}

// One thread per path, as long as a wave holds a pixel once; see `accumulate/entry.wgsl`.
@compute @workgroup_size(64)
fn trace_paths(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
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
    for (var slot = first; slot < frame.wave_size; slot += frame.padded_pixels) {
        if (path_id(slot).sample >= frame.sample_limit) {
            break;
        }
        trace_path(slot);
        var sums = sums_read(at);
        add_sample(&sums, slot);
        sums_write(at, sums);
    }
}
