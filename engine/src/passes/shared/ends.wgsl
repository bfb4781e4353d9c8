// Paths that end before their time.
//!include shared/wave_memory.wgsl

// From now on the path carries nothing, and its ray meets nothing.
fn end_path(slot: u32) {
    path_set_words(PATH_THROUGHPUT, slot, vec4u(0u));
    rays[own_ray(slot)].t_max = DEAD;
}
