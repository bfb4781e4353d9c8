//!include photons/states.wgsl
// What the passes of the photon map are told. The Rust twin is `renderer::photons::Settings`.

struct PhotonSettings {
    mode: u32,
    photons: u32, // that start in a pass, and the most that are kept
    field: u32, // of a path's state, the first of two that are the photons' own
    seed: u32, // of the pass
    radius: f32, // of a photon over its distance to the camera; metres where rays of the camera are parallel
    nearest: f32, // distances count as at least so much
    cell_mask: u32, // cells of the map less one: a power of two
    references: u32, // most that there is room for
    light_count: u32, // those with a place
    directional_count: u32,
    environment: u32, // whether it emits photons
    target_count: u32,
    targets: array<vec4f, 16>, // spheres around all that throws caustics: centre and radius
}

@group(0) @binding(56) var<uniform> photon_settings: PhotonSettings;

// Paths go on as if there were no photons.
const PHOTONS_IDLE = 0u;
// Light that casters have thrown on surfaces that scatter diffusely is taken from the map.
const PHOTONS_USED = 1u;

// Number of lights of all kinds.
fn all_lights() -> u32 {
    return photon_settings.light_count + photon_settings.directional_count + photon_settings.environment;
}
