// Ambient occlusion as the pass `ao` has counted it.
//!include shared/ao_tables.wgsl

// Four counts of eight bits for the hit of a ray.
fn occluded_rays(ray: u32) -> u32 {
    return atomicLoad(&queues[ao_word(ray)]);
}

// 1 where nothing is near, 0 where everything is occluded.
fn patina_attr_AO(slot: u32) -> vec4f {
    let table = slot & 3u;
    let occluded = f32((site.occluded >> (8u * table)) & 0xffu);
    return vec4f(1.0 - occluded / max(f32(ao_tables[table].samples), 1.0));
}
