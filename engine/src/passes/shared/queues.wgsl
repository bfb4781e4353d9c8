// Compacted lists of path slots, one per kind of work (`queue_lists.wgsl`), and the totals for statistics. One buffer,
// because at most eight storage buffers may be bound. The Rust twin of the layout is in `wave`.
//
// Word 2k is what producers of queue k have appended, word 2k+1 what its consumers may read; `advance` moves the one
// to the other between kernels.

const QUEUE_ACTIVE = 0u; // paths whose ray is to be traced
const QUEUE_SHADOW = 1u; // paths with a shadow ray
const QUEUE_PROCTEX = 2u; // hits whose material has a program: index into `rays`, and ENTRY_LIGHT
const QUEUE_AO = 3u; // hits whose program reads ambient occlusion: index into `rays`, then AO mask in the top 4 bits
const QUEUE_COUNT = 4u;

// Bits of the entries of QUEUE_PROCTEX and QUEUE_AO.
const ENTRY_RAY = 0x0fffffffu;
const ENTRY_LIGHT = 0x80000000u; // the hit is a point of a light that was sampled

const WORD_ROUND = 8u; // how often the list of active paths has been handed on, of which its halves take turns
const WORD_RAYS = 9u; // 64-bit total of path and shadow rays
const WORD_OVERRUN = 11u; // number + 1 of a texture whose loops were ended early, or 0
const WORD_CLAMPED = 12u; // samples beyond the film's range
const WORD_AO_RAYS = 13u; // 64-bit total of the rays that hits ask for
const WORD_INVALID = 15u; // samples that were not finite and were dropped
const WORD_SHADOW_RAYS = 16u; // 64-bit total of shadow rays alone
const WORD_AO_FREE = 18u; // 64-bit total of AO rays that needn't be traced
const WORD_NON_FINITE = 20u; // 64-bit total of hits whose texture program drove something by a value that was not finite
const WORD_NON_FINITE_NODE = 22u; // place + 1 in the fake stack of the arguments of a node that gave one, or 0
const QUEUE_HEADER = 32u;

@group(0) @binding(3) var<storage, read_write> queues: array<atomic<u32>>;

// Adds to a 64-bit total.
fn add_total(word: u32, count: u32) {
    let before = atomicAdd(&queues[word], count);
    if (before + count < before) {
        atomicAdd(&queues[word + 1u], 1u);
    }
}
