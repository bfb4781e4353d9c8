// How a piece of light came to the camera, where the film keeps parts of the light apart. A path leaves in its fields what
// its own ray has found and how the first surface has scattered it; what its shadow ray brings is in PATH_LIGHT as ever.
//!include shared/paths.wgsl

// Words of a path's fields, which `split_field` finds:
// PATH_FOUND: rgb that the own ray has found since the last record, then `found_word`.
// PATH_FOUND_DISKS: the same of lamps infinitely far away.
// PATH_SHARES: `shares_words` of the light sample at hand, then of the path.

const SCATTERINGS_MOST = 2u; // two and more are not told apart
const FOUND_SURFACE = 4u;
const FOUND_GIVEN = 8u; // a cache has given it for the first surface
const FOUND_REST = 16u; // photons bring what of it the first surface scatters diffusely
const FOUND_GROUP_SHIFT = 8u;
const NO_GROUP = 0u; // of what is in no group of lights; of what caches give, too, where there are no groups

fn found_word(scatterings: u32, is_surface: bool, group: u32) -> u32 {
    let surface = select(0u, FOUND_SURFACE, is_surface);
    return min(scatterings, SCATTERINGS_MOST) | surface | (group << FOUND_GROUP_SHIFT);
}

const SHARES_ABOVE = 0x10000u;
const SHARES_REST = 0x20000u; // as FOUND_REST
const SHARES_GROUP_SHIFT = 24u;

// The share of diffuse scattering in each channel; the rest is glossy where the light came from above the surface, and
// transmitted where it came from below. `group` is that of the lamp.
fn shares_words(diffuse: vec3f, is_above: bool, group: u32) -> vec2u {
    let whole = vec3u(saturate(diffuse) * 65535.0 + 0.5);
    let above = select(0u, SHARES_ABOVE, is_above);
    return vec2u(whole.x | (whole.y << 16u), whole.z | above | (group << SHARES_GROUP_SHIFT));
}

fn shares_diffuse(words: vec2u) -> vec3f {
    return vec3f(vec3u(words.x & 0xffffu, words.x >> 16u, words.y & 0xffffu)) / 65535.0;
}

// A piece of light.
struct Found {
    light: vec3f,
    scatterings: u32, // surfaces that have scattered it: 0, 1, or 2 for more
    is_surface: bool, // it comes from a surface that emits; said where nothing has scattered it
    group: u32, // of lights
    diffuse: vec3f, // the share that the first surface has scattered diffusely
    is_above: bool, // whether the first surface has reflected the rest, or let it through
    // Of a shadow catcher's light sample alone, for its shadow: what it would bring if nothing were in its way, and what it brings.
    shadowless: vec3f,
    arrived: vec3f,
}
