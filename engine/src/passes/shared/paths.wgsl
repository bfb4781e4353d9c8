// State of a path: its fields, and what can be said about them. Where they lie, `wave_memory.wgsl` says.
// The Rust twin is `wave::PATH_FIELDS`.
//!include shared/abilities.wgsl

const PATH_THROUGHPUT = 0u; // rgb, then the pdf of the direction that was sampled last (0: not from a BSDF)
const PATH_RADIANCE = 1u; // rgb gathered so far, then the ray cone's width at the ray's origin
// rgb that arrives if the shadow ray is free, then what light samples know of the vertex scattered at last, for the weight
// of a lamp that the path's ray hits: see `light_tree.wgsl`
const PATH_LIGHT = 2u;
// Material after blends, its driven outputs, vertices that have scattered with PATH_ENDS, and the hue of a path that was dispersed,
// see media.wgsl, or 0.
const PATH_STATE = 3u;
const PATH_LIGHT_POINT = 4u; // triangle (or MISS), instance and barycentrics of a light that a program has yet to judge
const PATH_MEDIA = 5u; // the bodies that the path is in, see media.wgsl; read only where light goes through something
const PATH_RESULTS = 6u; // the driven outputs' values, word by word: as many fields as the hungriest material needs

// Before these, where `leaves_diffuse`: see left.wgsl.
const PATH_PLACE = 6u;
const PATH_DIFFUSE = 7u;
const PATH_LEFT = 8u;
const PATH_UNSENT = 9u;
const LEFT_FIELDS = 4u;

// Behind them, where the film keeps parts of the light apart, by their numbers for `split_field`: see found_light.wgsl.
const PATH_FOUND = 0u;
const PATH_FOUND_DISKS = 1u;
const PATH_SHARES = 2u;
const SPLIT_FIELDS = 3u;
// Where it has shadow catchers: rgb that the light sample of the first surface would bring if nothing were in its way and
// no other sample could have found it, then the greatest component of what PATH_LIGHT was.
const PATH_CAUGHT = 3u;

// Whether it does.
override splits_light: bool = false;
override catches_shadows: bool = false; // only where the former is true

fn split_field(number: u32) -> u32 {
    return PATH_RESULTS + select(0u, LEFT_FIELDS, leaves_diffuse) + number;
}

// Behind them, where also `leaves_diffuse`: as PATH_FOUND, what the hashed cache has given for the surface at which the path ends.
fn path_ended() -> u32 {
    return split_field(SPLIT_FIELDS + select(0u, 1u, catches_shadows));
}

// The same of records and photons for the surface before.
fn path_given() -> u32 {
    return path_ended() + 1u;
}

// `shares_words` of what these give for the first surface; then of what is photons' of the light sample that waits, without SHARES_ABOVE.
fn path_given_shares() -> u32 {
    return path_ended() + 2u;
}

const GIVEN_FIELDS = 3u;

fn results_field() -> u32 {
    let split = SPLIT_FIELDS + select(0u, 1u, catches_shadows) + select(0u, GIVEN_FIELDS, leaves_diffuse);
    return split_field(select(0u, split, splits_light));
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

// Of a path that a cache has given the rest of its light: at its next surface it ends, as if it had scattered as often as it may.
const PATH_ENDS = 0x80000000u;

// Vertices of the path that have scattered.
fn path_depth(slot: u32) -> u32 {
    return path_words(PATH_STATE, slot).z & ~PATH_ENDS;
}

// Whether the path's next surface scatters no more of its light: then only what that emits is found there.
fn path_is_last(slot: u32) -> bool {
    return path_words(PATH_STATE, slot).z >= frame.max_depth;
}
