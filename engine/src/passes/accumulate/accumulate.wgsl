// Adds the finished paths of a wave to the film: the sum and the sum of squares of each pixel's samples.
// One thread owns a pixel and adds its samples in their order, so the film doesn't depend on the wave's size.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/queues.wgsl

@group(0) @binding(5) var<storage, read_write> film_sum: array<vec4f>; // rgb and number of samples
@group(0) @binding(6) var<storage, read_write> film_sum_squares: array<vec4f>;

@compute @workgroup_size(64)
fn accumulate(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
              @builtin(local_invocation_index) local: u32) {
    let first = thread_index(workgroup, workgroups, local);
    if (first >= min(frame.wave_size, frame.padded_pixels)) {
        return;
    }
    let pixel = pixel_coordinates(path_id(first).pixel);
    if (pixel.x >= frame.width || pixel.y >= frame.height) {
        return;
    }
    let at = pixel.y * frame.width + pixel.x;
    var sum = film_sum[at];
    var squares = film_sum_squares[at];
    for (var slot = first; slot < frame.wave_size; slot += frame.padded_pixels) {
        if (path_id(slot).sample >= frame.sample_limit) {
            break;
        }
        var value = path_read(PATH_RADIANCE, slot).xyz;
        // Unless the shadow ray met more surfaces than anyone waits for.
        let is_known = !has_program_shadows || path_words(PATH_LIGHT_POINT, slot).x == MISS;
        if (rays[frame.capacity + slot].triangle == MISS && is_known) {
            value += path_read(PATH_LIGHT, slot).xyz;
        }
        // A sample that isn't finite would spoil its pixel for good. Comparisons with NaN are false.
        if (!(all(value >= vec3f(0.0)) && all(value <= vec3f(1e30)))) {
            value = vec3f(0.0);
            atomicAdd(&queues[WORD_INVALID], 1u);
        }
        sum += vec4f(value, 1.0);
        squares += vec4f(value * value, 0.0);
    }
    film_sum[at] = sum;
    film_sum_squares[at] = squares;
}
