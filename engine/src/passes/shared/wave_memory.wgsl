// Where the passes keep what they hand each other: the rays and the state of a wave's paths, slot by slot. State lies field
// by field, so that neighbouring threads touch neighbouring words. `rayquery/path_memory.wgsl` takes this file's place
// where one thread keeps a path to itself.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl

// [0, capacity): the paths' own rays; [capacity, 2 capacity): their shadow rays.
@group(0) @binding(1) var<storage, read_write> rays: array<RayHit>;
@group(0) @binding(2) var<storage, read_write> paths: array<vec4u>;

// Places in `rays`.
fn own_ray(slot: u32) -> u32 {
    return slot;
}

fn shadow_ray(slot: u32) -> u32 {
    return frame.capacity + slot;
}

fn is_shadow_ray(ray: u32) -> bool {
    return ray >= frame.capacity;
}

// The path of a ray.
fn ray_slot(ray: u32) -> u32 {
    return select(ray, ray - frame.capacity, is_shadow_ray(ray));
}

fn ray_read(ray: u32) -> RayHit {
    return rays[ray];
}

fn path_words(field: u32, slot: u32) -> vec4u {
    return paths[field * frame.capacity + slot];
}

fn path_set_words(field: u32, slot: u32, value: vec4u) {
    paths[field * frame.capacity + slot] = value;
}

// Word `at` of the results of the path's texture program.
fn result_read(slot: u32, at: u32) -> f32 {
    return bitcast<f32>(paths[(results_field() + at / 4u) * frame.capacity + slot][at % 4u]);
}

fn result_write(slot: u32, at: u32, value: f32) {
    paths[(results_field() + at / 4u) * frame.capacity + slot][at % 4u] = bitcast<u32>(value);
}
