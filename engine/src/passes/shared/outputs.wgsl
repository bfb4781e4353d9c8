// What of a material a texture program can drive. Numbers (OUTPUT_...) and masks are made from the table of parameters:
// `material_record`. Which outputs are driven is one word, a head's flags and PATH_STATE's second word. Where there are
// more than fit, OUTPUTS_MORE says that a second word lies before the results of those it is about. As long as all fit,
// HAS_MORE_OUTPUTS leaves nothing of it in a kernel.
//!include generated/outputs.wgsl

fn has_bit(bits: u32, which: u32) -> bool {
    return (bits & (1u << which)) != 0u;
}

// Whether an output has three components; one otherwise.
fn is_vector(which: u32) -> bool {
    if (HAS_MORE_OUTPUTS && which >= OUTPUTS_LOW) {
        return has_bit(OUTPUT_VECTORS_MORE, which - OUTPUTS_LOW);
    }
    return has_bit(OUTPUT_VECTORS, which);
}

// Words of the results whose bits are in `outputs`.
fn result_words(outputs: u32, vectors: u32) -> u32 {
    return countOneBits(outputs) + 2u * countOneBits(outputs & vectors);
}

// Where the second word lies among the path's results.
fn more_place(outputs: u32) -> u32 {
    return result_words(outputs & (OUTPUTS_MORE - 1u), OUTPUT_VECTORS);
}

fn more_outputs(slot: u32, outputs: u32) -> u32 {
    return bitcast<u32>(result_read(slot, more_place(outputs)));
}

// Whether an output is among those of a path.
fn has_output(slot: u32, outputs: u32, which: u32) -> bool {
    if (HAS_MORE_OUTPUTS && which >= OUTPUTS_LOW) {
        if ((outputs & OUTPUTS_MORE) == 0u) {
            return false;
        }
        return has_bit(more_outputs(slot, outputs), which - OUTPUTS_LOW);
    }
    return has_bit(outputs, which);
}

// Its word among the path's results: those of outputs with lower numbers come first.
fn result_place(slot: u32, outputs: u32, which: u32) -> u32 {
    if (HAS_MORE_OUTPUTS && which >= OUTPUTS_LOW) {
        let before = more_outputs(slot, outputs) & ((1u << (which - OUTPUTS_LOW)) - 1u);
        return more_place(outputs) + 1u + result_words(before, OUTPUT_VECTORS_MORE);
    }
    return result_words(outputs & ((1u << which) - 1u), OUTPUT_VECTORS);
}
