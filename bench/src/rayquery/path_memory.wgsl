// In the place of `shared/wave_memory.wgsl` and `shared/queue_lists.wgsl` where one thread takes a path from its start to
// its end: what the passes hand each other in buffers stays with the thread.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/queues.wgsl

// RESULT_WORDS, the words that the hungriest material's results take, stands at the end of the kernel.

var<private> rays: array<RayHit, 2>; // the path's own ray, then its shadow ray
var<private> path_fields: array<vec4u, PATH_RESULTS>;
var<private> results: array<f32, RESULT_WORDS>;
var<private> goes_on: bool; // the path's own ray is to be traced
var<private> shadow_waits: bool; // its shadow ray is to be traced
var<private> entries: array<u32, 2>; // hits with a program, as in QUEUE_PROCTEX
var<private> entry_count: u32;

fn own_ray(slot: u32) -> u32 {
    return 0u;
}

fn shadow_ray(slot: u32) -> u32 {
    return 1u;
}

fn is_shadow_ray(ray: u32) -> bool {
    // A compiler that knows that programs see own rays alone can keep both in registers.
    return has_program_shadows && ray == 1u;
}

fn ray_read(ray: u32) -> RayHit {
    if (is_shadow_ray(ray)) {
        return rays[1];
    }
    return rays[0];
}

fn path_words(field: u32, slot: u32) -> vec4u {
    return path_fields[field];
}

fn path_set_words(field: u32, slot: u32, value: vec4u) {
    path_fields[field] = value;
}

fn result_read(slot: u32, at: u32) -> f32 {
    return results[at];
}

fn result_write(slot: u32, at: u32, value: f32) {
    results[at] = value;
}

fn queue_append(queue: u32, entry: u32) {
    switch queue {
        case QUEUE_ACTIVE: { goes_on = true; }
        case QUEUE_SHADOW: { shadow_waits = true; }
        default: {
            entries[entry_count & 1u] = entry;
            entry_count += 1u;
        }
    }
}

// Ambient occlusion is traced where it is read.
fn queue_append_ao(ray: u32, tables: u32) {}
