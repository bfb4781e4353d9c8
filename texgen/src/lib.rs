//! User textures in WGSL to one procedural-texture kernel. Knows naga; knows neither wgpu nor the engine.
