// As `proctex/proctex.wgsl`, for texgen's inlined form: ambient occlusion is traced here, as renderers do that paste textures into
// their kernels. It binds more storage buffers than every device has; only comparisons need it.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include proctex/site.wgsl
//!include shared/materials.wgsl
//!include shared/traversal.wgsl
//!include shared/occlusion_bundles.wgsl
//!include inlined/traced_ao.wgsl
//!include proctex/run.wgsl
//!include proctex/entry.wgsl

// As the pass `ao` does.
fn occluded_of_site(at: OcclusionSite) -> u32 {
    return occlusion_of_all(at).occluded;
}
