// Which pixel a thread adds the samples of a wave to: it owns it, and goes through the wave sample by sample.
//!include shared/frame.wgsl

const NO_PIXEL = 0xffffffffu;

// The pixel of a thread, or NO_PIXEL if it has none to work on.
fn own_pixel(first: u32) -> u32 {
    if (first >= min(frame.wave_size, frame.padded_pixels)) {
        return NO_PIXEL;
    }
    // Both numbers are below `padded_pixels`: no division is needed, as it is for other slots.
    let linear = frame.first_pixel + first;
    var padded = select(linear, linear - frame.padded_pixels, linear >= frame.padded_pixels);
    if (frame.lot_samples != 0u) {
        padded = path_id(first_slot(first)).pixel;
    }
    let pixel = pixel_coordinates(padded);
    return select(NO_PIXEL, pixel.y * frame.width + pixel.x, is_rendered(pixel));
}

// The sample of a thread's first slot.
fn own_sample(first: u32) -> u32 {
    if (frame.lot_samples != 0u) {
        return path_id(first_slot(first)).number;
    }
    return frame.first_sample + u32(frame.first_pixel + first >= frame.padded_pixels);
}

// Behind the last slot of the wave whose path is of this job.
fn last_slot(first: u32) -> u32 {
    let sample = own_sample(first);
    if (sample >= frame.sample_limit) {
        return first_slot(first);
    }
    if (frame.lot_samples != 0u) {
        return first_slot(first) + min(frame.sample_limit - sample, frame.lot_samples);
    }
    if (first + frame.padded_pixels >= frame.wave_size) {
        return first + 1u;
    }
    // Those that are left may be more than slots can be counted.
    let rounds = (frame.wave_size - first + frame.padded_pixels - 1u) / frame.padded_pixels;
    return min(frame.wave_size, first + min(frame.sample_limit - sample, rounds) * frame.padded_pixels);
}
