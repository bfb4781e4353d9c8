// Between two kernels: hands the queues from their producers to their consumers, writes the sizes of the next
// dispatches, and keeps the totals.
//!include shared/frame.wgsl
//!include shared/queues.wgsl
//!include shared/ao_tables.wgsl

// Three words (x, y, z workgroups) per queue.
@group(0) @binding(4) var<storage, read_write> dispatch_sizes: array<u32>;

const GROUPS_X = 32768u;

fn hand_over(queue: u32) -> u32 {
    let count = atomicLoad(&queues[2u * queue]);
    atomicStore(&queues[2u * queue], 0u);
    atomicStore(&queues[2u * queue + 1u], count);
    return count;
}

fn size_dispatch(queue: u32, threads: u32) {
    let groups = (threads + 63u) / 64u;
    dispatch_sizes[3u * queue] = min(groups, GROUPS_X);
    dispatch_sizes[3u * queue + 1u] = (groups + GROUPS_X - 1u) / GROUPS_X;
    dispatch_sizes[3u * queue + 2u] = 1u;
}

// After raygen: round 0 reads what raygen appended.
@compute @workgroup_size(1)
fn advance_start() {
    let live = hand_over(QUEUE_ACTIVE);
    size_dispatch(QUEUE_ACTIVE, live);
    // raygen appended as round -1.
    atomicStore(&queues[WORD_ROUND], 0u);
    add_total(WORD_RAYS, live);
}

// After classify.
@compute @workgroup_size(1)
fn advance_texture() {
    size_dispatch(QUEUE_PROCTEX, hand_over(QUEUE_PROCTEX));
    size_dispatch(QUEUE_AO, hand_over(QUEUE_AO) * ao_threads());
}

// After brdf.
@compute @workgroup_size(1)
fn advance_bounce() {
    let live = hand_over(QUEUE_ACTIVE);
    let shadow = hand_over(QUEUE_SHADOW);
    size_dispatch(QUEUE_ACTIVE, live);
    size_dispatch(QUEUE_SHADOW, shadow);
    atomicAdd(&queues[WORD_ROUND], 1u);
    add_total(WORD_RAYS, live + shadow);
    add_total(WORD_SHADOW_RAYS, shadow);
}

// After gather_first_hit, which hands on what is left of the active paths. Their rays are counted already.
@compute @workgroup_size(1)
fn advance_followed() {
    size_dispatch(QUEUE_ACTIVE, hand_over(QUEUE_ACTIVE));
    atomicAdd(&queues[WORD_ROUND], 1u);
}
