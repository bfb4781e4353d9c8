// The same photons found in three ways, of which each adds up the same whole numbers: the renderer's octree of references, its grid
// of sorted photons, and a kd-tree.
//!include photons/look_up.wgsl

// Two for each place that asks: position, and octahedral normal.
@group(0) @binding(63) var<storage, read> places: array<vec4u>;
@group(0) @binding(64) var<storage, read_write> found: array<vec4u>;

const MOST_CASTERS = 8u;

@compute @workgroup_size(64)
fn by_octree(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < arrayLength(&places)) {
        let place = places[id.x];
        let flux = flux_by_octree(bitcast<vec3f>(place.xyz), octahedral_decode(place.w), MOST_CASTERS);
        found[id.x] = vec4u(flux, 0u);
    }
}

@compute @workgroup_size(64)
fn by_grid(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < arrayLength(&places)) {
        let place = places[id.x];
        let flux = flux_by_grid(bitcast<vec3f>(place.xyz), octahedral_decode(place.w), MOST_CASTERS);
        found[id.x] = vec4u(flux, 0u);
    }
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
                    && (carried.w & PHOTON_SCATTERED) <= MOST_CASTERS;
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
