// The same photons found in three ways, of which each adds up the same whole numbers: the renderer's octree of references, a grid
// whose cells hold the photons that lie in them, and a kd-tree.
//!include photons/look_up.wgsl

// Two for each place that asks: position, and octahedral normal.
@group(0) @binding(61) var<storage, read> places: array<vec4u>;
@group(0) @binding(62) var<storage, read_write> found: array<vec4u>;
// Of each cell of the grid where its photons begin, and how many there are.
@group(0) @binding(63) var<storage, read> grid: array<vec2u>;

@compute @workgroup_size(64)
fn by_octree(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < arrayLength(&places)) {
        let place = places[id.x];
        found[id.x] = vec4u(photon_flux(bitcast<vec3f>(place.xyz), octahedral_decode(place.w), MOST_CASTERS), 0u);
    }
}

const MOST_CASTERS = 8u;

// Cells are two radii wide, so that a place's photons lie in eight of them at most.
@compute @workgroup_size(64)
fn by_grid(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&places)) {
        return;
    }
    let place = places[id.x];
    let position = bitcast<vec3f>(place.xyz);
    let facing = octahedral_decode(place.w);
    let radius = photon_radius(position);
    let low = vec3i(floor((position - radius) / (2.0 * radius)));
    let high = min(vec3i(floor((position + radius) / (2.0 * radius))), low + 1);
    var flux = vec3u(0u);
    var seen: array<u32, 8>;
    var count = 0u;
    for (var z = low.z; z <= high.z; z++) {
        for (var y = low.y; y <= high.y; y++) {
            for (var x = low.x; x <= high.x; x++) {
                let at = grid_cell(vec3i(x, y, z));
                // Two cells may share a place.
                var is_new = true;
                for (var i = 0u; i < count; i++) {
                    is_new = is_new && seen[i] != at;
                }
                if (!is_new) {
                    continue;
                }
                seen[count] = at;
                count++;
                let cell = grid[at];
                for (var i = cell.x; i < cell.x + cell.y; i++) {
                    flux += flux_of(1u + 2u * i, position, facing, radius, MOST_CASTERS);
                }
            }
        }
    }
    found[id.x] = vec4u(flux, 0u);
}

// The place of a cell; `gather.rs` has the same.
fn grid_cell(cell: vec3i) -> u32 {
    let words = vec3u(bitcast<u32>(cell.x), bitcast<u32>(cell.y), bitcast<u32>(cell.z));
    return hash2(hash2(hash(words.x), words.y), words.z) & (arrayLength(&grid) - 1u);
}

// A left-balanced tree: the children of node i are 2i + 1 and 2i + 2. Its axis is in the two highest bits of a photon's last word.
@compute @workgroup_size(64)
fn by_tree(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&places)) {
        return;
    }
    let place = places[id.x];
    let position = bitcast<vec3f>(place.xyz);
    let facing = octahedral_decode(place.w);
    let radius = photon_radius(position);
    let count = photons[0].x;
    var flux = vec3u(0u);
    var stack: array<u32, 24>;
    var height = 0u;
    var node = 0u;
    loop {
        if (node < count) {
            let at = 1u + 2u * node;
            let own = photons[at];
            let carried = photons[at + 1u];
            let axis = carried.w >> 30u;
            let off = position - bitcast<vec3f>(own.xyz);
            if (dot(off, off) <= radius * radius) {
                let normal = octahedral_decode(own.w);
                let counts = dot(normal, facing) > LEAST_FACING && abs(dot(off, normal)) <= MOST_HEIGHT * radius
                    && (carried.w & 0xffffu) <= MOST_CASTERS;
                flux += select(vec3u(0u), carried.xyz, counts);
            }
            let aside = off[axis];
            let near = 2u * node + select(2u, 1u, aside < 0.0);
            let far = 4u * node + 3u - near;
            if (abs(aside) <= radius) {
                stack[height] = far;
                height++;
            }
            node = near;
            continue;
        }
        if (height == 0u) {
            break;
        }
        height--;
        node = stack[height];
    }
    found[id.x] = vec4u(flux, 0u);
}
