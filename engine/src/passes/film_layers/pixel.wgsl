// Which pixel a thread adds the samples of a wave to: it owns it, and goes through the wave sample by sample.
//!include shared/frame.wgsl

const NO_PIXEL = 0xffffffffu;

// The pixel of a thread, or NO_PIXEL if it has none to work on.
fn own_pixel(first: u32) -> u32 {
    if (first >= min(frame.wave_size, frame.padded_pixels)) {
        return NO_PIXEL;
    }
    let pixel = pixel_coordinates(path_id(first).pixel);
    return select(NO_PIXEL, pixel.y * frame.width + pixel.x, is_rendered(pixel));
}

// Behind the last slot of the wave whose path is of this job: a pixel's next sample is `padded_pixels` slots further on.
fn last_slot(first: u32) -> u32 {
    let sample = path_id(first).number;
    let left = select(frame.sample_limit - sample, 0u, sample >= frame.sample_limit);
    // Those that are left may be more than slots can be counted.
    let rounds = (frame.wave_size - first + frame.padded_pixels - 1u) / frame.padded_pixels;
    return min(frame.wave_size, first + min(left, rounds) * frame.padded_pixels);
}
