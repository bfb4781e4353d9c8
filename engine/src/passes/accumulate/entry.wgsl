// Adds the finished paths of a wave to the film. One thread owns a pixel.
//!include shared/wave_memory.wgsl
//!include accumulate/accumulate.wgsl

@compute @workgroup_size(64)
fn accumulate(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
              @builtin(local_invocation_index) local: u32) {
    let first = thread_index(workgroup, workgroups, local);
    if (first >= min(frame.wave_size, frame.padded_pixels)) {
        return;
    }
    let pixel = pixel_coordinates(path_id(first_slot(first)).pixel);
    if (!is_rendered(pixel)) {
        return;
    }
    let at = pixel.y * frame.width + pixel.x;
    var sums = sums_read(at);
    let end = end_slot(first);
    for (var slot = first_slot(first); slot < end; slot += slot_stride()) {
        if (path_id(slot).number >= frame.sample_limit) {
            break;
        }
        add_sample(&sums, slot);
    }
    sums_write(at, sums);
}
