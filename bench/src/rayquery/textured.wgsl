// The path tracer in one kernel with texture programs: texgen's inlined form is appended to this file, and ambient
// occlusion is traced in a loop inside.
enable wgpu_ray_query;
//!include rayquery/kernel.wgsl
//!include classify/classify.wgsl
//!include proctex/site.wgsl
//!include inlined/traced_ao.wgsl
//!include proctex/run.wgsl

// One loop, so that the users' functions stand in the kernel once.
fn run_programs(slot: u32) {
    entry_count = 0u;
    classify_hits(slot);
    for (var i = 0u; i < min(entry_count, 2u); i++) {
        run_textures(entries[i], slot);
    }
}

fn occluded_of_site(at: OcclusionSite) -> u32 {
    var occluded = 0u;
    for (var sample = 0u; sample < at.table.samples; sample++) {
        occluded += occlusion(at, sample).occluded;
    }
    return occluded;
}
