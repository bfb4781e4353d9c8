// Compacted lists of path slots, one per kind of work, and the totals for statistics. One buffer, because at most
// eight storage buffers may be bound. The Rust twin of the layout is in `wave`.
//
// Word 2k is what producers of queue k have appended, word 2k+1 what its consumers may read; `advance` moves the one
// to the other between kernels.

const QUEUE_ACTIVE = 0u; // paths whose ray is to be traced
const QUEUE_SHADOW = 1u; // paths with a shadow ray
const QUEUE_PROCTEX = 2u; // hits whose material has a program
const QUEUE_AO = 3u; // hits whose program reads ambient occlusion: slot, then AO mask in the top 4 bits
const QUEUE_COUNT = 4u;

const WORD_BOUNCE = 8u; // scattering vertices so far
const WORD_RAYS = 9u; // 64-bit total of path and shadow rays
const WORD_OVERRUN = 11u; // number + 1 of a texture whose loops were ended early, or 0
const WORD_AO_RAYS = 13u; // 64-bit total
const WORD_INVALID = 15u; // samples that were not finite and were dropped
const QUEUE_HEADER = 16u;

@group(0) @binding(3) var<storage, read_write> queues: array<atomic<u32>>;

// The active list is read and written by the same kernel, so it has two halves that swap with each bounce.
fn queue_base(queue: u32, half: u32) -> u32 {
    return QUEUE_HEADER + frame.capacity * select(queue + 1u, half, queue == QUEUE_ACTIVE);
}

fn queue_length(queue: u32) -> u32 {
    return atomicLoad(&queues[2u * queue + 1u]);
}

fn bounce_number() -> u32 {
    return atomicLoad(&queues[WORD_BOUNCE]);
}

fn queue_read(queue: u32, index: u32) -> u32 {
    return atomicLoad(&queues[queue_base(queue, bounce_number() & 1u) + index]);
}

// Appends to the half that the next bounce reads.
fn queue_append(queue: u32, entry: u32) {
    let index = atomicAdd(&queues[2u * queue], 1u);
    atomicStore(&queues[queue_base(queue, (bounce_number() + 1u) & 1u) + index], entry);
}

// Occluded AO rays of a slot: eight bits for each of four AO tables.
fn ao_word(slot: u32) -> u32 {
    return QUEUE_HEADER + frame.capacity * (QUEUE_COUNT + 1u) + slot;
}
