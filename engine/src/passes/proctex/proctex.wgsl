// Runs the texture programs of the hits that have one. The generated part (texgen) is appended to this file: the
// users' functions and the interpreter `patina_run_program`. Here are the calls that it makes and the frame around it.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include proctex/site.wgsl
//!include proctex/counted_ao.wgsl
//!include proctex/run.wgsl
//!include proctex/entry.wgsl
