// The photons around a place: `gather.wgsl` is the pass that asks for them, and others look for them in other ways to be compared
// with.
//!include shared/geometry.wgsl
//!include photons/records.wgsl

@group(0) @binding(59) var<storage, read> photon_cells: array<vec4u>;
@group(0) @binding(60) var<storage, read> photon_references: array<u32>;
@group(0) @binding(61) var<storage, read> photon_grid: array<vec2u>;
@group(0) @binding(62) var<storage, read> photons: array<vec4u>;

// Photons count if the side that they met faces about where this one does.
const LEAST_FACING = 0.5;

// Whether a photon is so near. `at` is where its words are.
fn is_near(at: u32, position: vec3f, facing: vec3f, radius: f32) -> bool {
    let place = photons[at];
    let off = position - bitcast<vec3f>(place.xyz);
    if (dot(off, off) > radius * radius) {
        return false;
    }
    let normal = octahedral_decode(place.w);
    return dot(normal, facing) > LEAST_FACING && abs(dot(off, normal)) <= MOST_HEIGHT * radius;
}

// What all photons bring that at most so many casters have scattered, as flux of `records.wgsl`.
fn photon_flux(position: vec3f, facing: vec3f, most_scattered: u32) -> vec3u {
    if (photons_by_grid) {
        return flux_by_grid(position, facing, most_scattered);
    }
    return flux_by_octree(position, facing, most_scattered);
}

fn flux_by_grid(position: vec3f, facing: vec3f, most_scattered: u32) -> vec3u {
    let radius = photon_radius(position);
    var finest = grid_level(radius);
    var coarsest = finest;
    if (frame.orthographic == 0u) {
        // Photons nearer to the camera, or farther away, may be in cells of another size.
        let change = photon_settings.radius * radius;
        finest = grid_level(radius - change);
        coarsest = grid_level(radius + change);
    }
    var flux = vec3u(0u);
    for (var level = finest; level <= coarsest; level++) {
        let side = side_of(level);
        let low = vec3i(floor((position - radius) / side));
        let high = vec3i(floor((position + radius) / side));
        for (var z = low.z; z <= high.z; z++) {
            for (var y = low.y; y <= high.y; y++) {
                for (var x = low.x; x <= high.x; x++) {
                    flux += flux_in_cell(level, vec3i(x, y, z), position, facing, radius, most_scattered);
                }
            }
        }
    }
    return flux;
}

fn flux_in_cell(level: u32, cell: vec3i, position: vec3f, facing: vec3f, radius: f32, most_scattered: u32) -> vec3u {
    let corner = vec3f(cell) * side_of(level);
    let off = clamp(position, corner, corner + side_of(level)) - position;
    // A little more, lest rounding lose what lies on the border.
    if (dot(off, off) > 1.001 * radius * radius) {
        return vec3u(0u);
    }
    let found = grid_cell(level, cell);
    let range = photon_grid[found.at + 1u];
    var flux = vec3u(0u);
    for (var i = range.x; i < range.x + range.y; i++) {
        if (is_near(1u + 2u * i, position, facing, radius)) {
            let carried = photons[2u + 2u * i];
            let counts = (carried.w >> PHOTON_CHECK_SHIFT) == found.check && (carried.w & PHOTON_SCATTERED) <= most_scattered;
            flux += select(vec3u(0u), carried.xyz, counts);
        }
    }
    return flux;
}

fn flux_by_octree(position: vec3f, facing: vec3f, most_scattered: u32) -> vec3u {
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
        let at = 1u + 2u * (reference & REFERENCE_PHOTON);
        if ((reference >> REFERENCE_SHIFT) == found.check && is_near(at, position, facing, radius)) {
            let carried = photons[at + 1u];
            flux += select(vec3u(0u), carried.xyz, (carried.w & PHOTON_SCATTERED) <= most_scattered);
        }
    }
    return flux;
}
