// State of a path: its fields, and what can be said about them. Where they lie, `wave_memory.wgsl` says.
// The Rust twin is `wave::PATH_FIELDS`.
//!include shared/abilities.wgsl

const PATH_THROUGHPUT = 0u; // rgb, then the pdf of the direction that was sampled last (0: not from a BSDF)
const PATH_RADIANCE = 1u; // rgb gathered so far, then the ray cone's width at the ray's origin
// rgb that arrives if the shadow ray is free, then what light samples know of the vertex scattered at last, for the weight
// of a lamp that the path's ray hits: see `light_tree.wgsl`
const PATH_LIGHT = 2u;
// Material after blends, its driven outputs, vertices that have scattered, and the hue of a path that was dispersed, see
// media.wgsl, or 0.
const PATH_STATE = 3u;
const PATH_LIGHT_POINT = 4u; // triangle (or MISS), instance and barycentrics of a light that a program has yet to judge
const PATH_MEDIA = 5u; // the bodies that the path is in, see media.wgsl; read only where light goes through something
const PATH_RESULTS = 6u; // the driven outputs' values, word by word: as many fields as the hungriest material needs

// Before these, where the film keeps parts of the light apart: see split.wgsl.
const PATH_FOUND = 6u;
const PATH_FOUND_DISKS = 7u;
const PATH_SHARES = 8u;
const SPLIT_FIELDS = 3u;
// Behind them, where it has shadow catchers: rgb that the light sample of the first surface would bring if nothing were in its way and
// no other sample could have found it, then the greatest component of what PATH_LIGHT was.
const PATH_CAUGHT = 9u;

// Whether it does.
override splits_light: bool = false;
override catches_shadows: bool = false; // only where the former is true

// In the same place, where `leaves_diffuse`: see left.wgsl. Never both.
const PATH_PLACE = 6u;
const PATH_DIFFUSE = 7u;
const PATH_LEFT = 8u;

fn results_field() -> u32 {
    return PATH_RESULTS + select(0u, SPLIT_FIELDS, splits_light || leaves_diffuse) + select(0u, 1u, catches_shadows);
}

// Whether texture programs decide about the opacity or the light of some surface. Then shadow rays wait for them, and a
// path whose end has come lives on until its last shadow ray is through: its own ray is dead, see DEAD.
override has_program_shadows: bool = true;

// `t_max` of a ray that can't hit anything.
const DEAD = -1.0;

fn path_read(field: u32, slot: u32) -> vec4f {
    return bitcast<vec4f>(path_words(field, slot));
}

fn path_write(field: u32, slot: u32, value: vec4f) {
    path_set_words(field, slot, bitcast<vec4u>(value));
}

// What light adds to a sample that this many surfaces have scattered: indirect light is clamped where that is asked for.
fn limited(light: vec3f, scatterings: f32) -> vec3f {
    let most = max(max(light.x, light.y), light.z);
    if (scatterings < 2.0 || most <= frame.indirect_clamp) {
        return light;
    }
    return light * (frame.indirect_clamp / most);
}

// The light sample that waits for its shadow ray, which so many surfaces will have scattered.
fn waiting_light(slot: u32, scatterings: u32) -> vec3f {
    return limited(path_read(PATH_LIGHT, slot).xyz, f32(scatterings));
}

// Vertices of the path that have scattered.
fn path_depth(slot: u32) -> u32 {
    return path_words(PATH_STATE, slot).z;
}
