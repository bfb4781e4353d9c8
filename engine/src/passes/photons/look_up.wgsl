// The photons around a place: `gather.wgsl` is the pass that asks for them, and others look for them in other ways to be compared
// with.
//!include shared/geometry.wgsl
//!include photons/records.wgsl

@group(0) @binding(58) var<storage, read> photons: array<vec4u>;
@group(0) @binding(59) var<storage, read> photon_cells: array<vec4u>;
@group(0) @binding(60) var<storage, read> photon_references: array<u32>;

// Photons count if the side that they met faces about where this one does.
const LEAST_FACING = 0.5;

// What a photon brings to a place, as `flux` of `records.wgsl`. `at` is where its words are.
fn flux_of(at: u32, position: vec3f, facing: vec3f, radius: f32, most_scattered: u32) -> vec3u {
    let place = photons[at];
    let off = position - bitcast<vec3f>(place.xyz);
    if (dot(off, off) > radius * radius) {
        return vec3u(0u);
    }
    let normal = octahedral_decode(place.w);
    let carried = photons[at + 1u];
    let counts = dot(normal, facing) > LEAST_FACING && abs(dot(off, normal)) <= MOST_HEIGHT * radius
        && carried.w <= most_scattered;
    return select(vec3u(0u), carried.xyz, counts);
}

// What all photons bring that at most so many casters have scattered.
fn photon_flux(position: vec3f, facing: vec3f, most_scattered: u32) -> vec3u {
    let radius = photon_radius(position);
    let root = root_level(radius);
    var depth = 0u;
    var found = map_cell(root, 0u, vec3i(floor(position / side_of(root))));
    var cell = photon_cells[found.at + 1u];
    while (cell.y != 0u && depth < MAP_DEPTH) {
        depth++;
        found = map_cell(root, depth, vec3i(floor(position / side_of(root - depth))));
        cell = photon_cells[found.at + 1u];
    }
    var flux = vec3u(0u);
    for (var i = cell.z; i < cell.z + cell.w; i++) {
        let reference = photon_references[i];
        if ((reference >> REFERENCE_SHIFT) == found.check) {
            flux += flux_of(1u + 2u * (reference & REFERENCE_PHOTON), position, facing, radius, most_scattered);
        }
    }
    return flux;
}
