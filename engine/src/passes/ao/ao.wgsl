// Ambient occlusion for the hits whose texture program reads it: all rays of all hits at once, each in a thread of its own,
// or all of a hit in one. Each occluded ray adds one to its table's eight bits of the slot's word.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/surface.wgsl
//!include shared/traversal.wgsl
//!include shared/occlusion.wgsl
//!include shared/occlusion_bundles.wgsl

@compute @workgroup_size(64)
fn ao(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
      @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    let threads = ao_threads();
    let entry_index = index / threads;
    let sample = index % threads;
    if (entry_index >= queue_length(QUEUE_AO)) {
        return;
    }
    let entry = queue_read(QUEUE_AO, entry_index);
    let ray = entry & ENTRY_RAY;
    let hit = rays[ray];
    let s = surface_at(hit);
    let is_shadow = is_shadow_ray(ray);
    let slot = ray_slot(ray);
    let path = path_id(slot);
    let purpose = vertex_dimension(path_depth(slot), select(DIMENSION_AO, DIMENSION_SHADOW_AO, is_shadow));
    // Only the tables that the entry names: a loop over all four would cost a software driver, which runs the body for
    // lanes that skip it too, four rays for one.
    var tables = entry >> 28u;
    var asked = 0u;
    var free = 0u;
    while (tables != 0u) {
        let i = firstTrailingBit(tables);
        tables &= tables - 1u;
        let count = ao_tables[i].samples;
        asked += count;
        let site = occlusion_site(s, hit.instance, path, purpose, i);
        var traced = Occlusion(0u, 0u);
        if (ao_thread_per_hit) {
            traced = occlusion_of_all(site);
        } else if (sample < count) {
            traced = occlusion(site, sample);
        }
        free += traced.free;
        if (traced.occluded != 0u) {
            atomicAdd(&queues[ao_word(ray)], traced.occluded << (8u * i));
        }
    }
    // One atomic for all rays of a hit: one for each ray took longer than some rays.
    if (sample == 0u) {
        add_total(WORD_AO_RAYS, asked);
    }
    if (free != 0u) {
        add_total(WORD_AO_FREE, free);
    }
}
