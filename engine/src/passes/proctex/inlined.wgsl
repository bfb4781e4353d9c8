// As `proctex.wgsl`, for texgen's inlined form: ambient occlusion is traced here, as renderers do that paste textures into
// their kernels. It binds more storage buffers than every device has; only comparisons need it.
//!include proctex/site.wgsl
//!include proctex/traced_ao.wgsl
//!include proctex/run.wgsl
