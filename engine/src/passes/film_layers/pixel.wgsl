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
