// The path tracer in one kernel for scenes without texture programs.
enable wgpu_ray_query;
//!include rayquery/kernel.wgsl

fn run_programs(slot: u32) {}
