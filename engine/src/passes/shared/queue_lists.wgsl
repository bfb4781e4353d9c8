// The lists of the passes: what one appends, another reads.
//!include shared/frame.wgsl
//!include shared/queues.wgsl

// The active list is read and written by the same kernel, so it has two halves that swap with each round. The lists of
// hits have room for one of each path's own ray and one of its shadow ray.
fn queue_base(queue: u32, half: u32) -> u32 {
    switch queue {
        case QUEUE_ACTIVE: { return QUEUE_HEADER + frame.capacity * half; }
        case QUEUE_SHADOW: { return QUEUE_HEADER + frame.capacity * 2u; }
        case QUEUE_PROCTEX: { return QUEUE_HEADER + frame.capacity * 3u; }
        default: { return QUEUE_HEADER + frame.capacity * 5u; }
    }
}

fn queue_length(queue: u32) -> u32 {
    return atomicLoad(&queues[2u * queue + 1u]);
}

fn round_number() -> u32 {
    return atomicLoad(&queues[WORD_ROUND]);
}

fn queue_read(queue: u32, index: u32) -> u32 {
    return atomicLoad(&queues[queue_base(queue, round_number() & 1u) + index]);
}

// Appends to the half that the next round reads.
fn queue_append(queue: u32, entry: u32) {
    let index = atomicAdd(&queues[2u * queue], 1u);
    atomicStore(&queues[queue_base(queue, (round_number() + 1u) & 1u) + index], entry);
}

// Occluded AO rays of the hit of ray `ray`: eight bits for each of four AO tables.
fn ao_word(ray: u32) -> u32 {
    return QUEUE_HEADER + frame.capacity * 7u + ray;
}

// Queues a hit of ray `ray` for the AO tables whose bits are set in `tables`.
fn queue_append_ao(ray: u32, tables: u32) {
    atomicStore(&queues[ao_word(ray)], 0u);
    queue_append(QUEUE_AO, ray | (tables << 28u));
}
