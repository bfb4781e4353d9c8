// State of the paths of a wave, field by field so that neighbouring threads touch neighbouring words.
// The Rust twin is `wave::PATH_FIELDS`.

const PATH_THROUGHPUT = 0u; // rgb, then the pdf of the direction that was sampled last (0: not from a BSDF)
const PATH_RADIANCE = 1u; // rgb gathered so far, then the ray cone's width at the ray's origin
const PATH_LIGHT = 2u; // rgb that arrives if the shadow ray is free
const PATH_PROC_BASE = 3u; // base colour and metallic of the texture programs
const PATH_PROC_EMISSION = 4u; // emission and roughness of the texture programs
const PATH_PROC_MATERIAL = 5u; // material after blends, bit mask of driven outputs

@group(0) @binding(2) var<storage, read_write> paths: array<vec4u>;

fn path_read(field: u32, slot: u32) -> vec4f {
    return bitcast<vec4f>(paths[field * frame.capacity + slot]);
}

fn path_write(field: u32, slot: u32, value: vec4f) {
    paths[field * frame.capacity + slot] = bitcast<vec4u>(value);
}
