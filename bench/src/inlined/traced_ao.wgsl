// Ambient occlusion traced inside the texture kernel, with the same rays as the pass `ao`: for comparison. Where this is included,
// `occluded_of_site` traces them.
//!include shared/materials.wgsl
//!include shared/occlusion.wgsl

// Nothing has been counted.
fn occluded_rays(ray: u32) -> u32 {
    return 0u;
}

// 1 where nothing is near, 0 where everything is occluded.
fn patina_attr_AO(slot: u32) -> vec4f {
    let table = slot & 3u;
    let samples = ao_tables[table].samples;
    var s = site.surface;
    s.position = site.anchor;
    let at = occlusion_site(s, site.instance, path_id(site.slot), site.ao_purpose, table);
    let occluded = occluded_of_site(at);
    return vec4f(1.0 - f32(occluded) / max(f32(samples), 1.0));
}
