//! The engine's tests that need nothing of a process of their own, as one program: linked once, with one support.

mod ahead;
mod support;

mod adaptive;
mod bsdf;
mod closed_forms;
mod crop;
mod custom_attributes;
mod driven_surfaces;
mod edits_are_data;
mod fleet;
mod footprint;
mod gallery;
mod image_arguments;
mod in_lanes;
mod irradiance;
mod khronos;
mod layouts;
mod library;
mod light_cache;
mod light_parts;
mod lights;
mod looks;
mod memory;
mod moments;
mod native;
mod openings;
mod outputs;
mod photons;
mod references;
mod session;
mod statistics;
mod texture_host;
mod texture_kernel;
mod texture_reload;
mod transparency;
