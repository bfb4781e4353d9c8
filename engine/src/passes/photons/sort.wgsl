// Sorts the photons that have arrived by cells of a grid. No passes of a wave.
//!include photons/records.wgsl
//!include shared/rays.wgsl

@group(0) @binding(58) var<storage, read> photons_arrived: array<vec4u>;
@group(0) @binding(61) var<storage, read_write> photon_grid: array<atomic<u32>>;
@group(0) @binding(62) var<storage, read_write> photons: array<vec4u>;

const GRID_WORDS = 2u;
const GRID_FIRST = 0u;
const GRID_LENGTH = 1u;

fn grid_word(at: u32, word: u32) -> u32 {
    return GRID_WORDS * (at + 1u) + word;
}

fn photon_count() -> u32 {
    return min(photons_arrived[0].x, photon_settings.photons);
}

fn cell_of(index: u32) -> MapCell {
    let position = bitcast<vec3f>(photons_arrived[1u + 2u * index].xyz);
    let level = grid_level(photon_radius(position));
    return grid_cell(level, vec3i(floor(position / side_of(level))));
}

// One thread for each photon. The grid is empty.
@compute @workgroup_size(64)
fn count_photons(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                 @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index < photon_count()) {
        atomicAdd(&photon_grid[grid_word(cell_of(index).at, GRID_LENGTH)], 1u);
    }
}

// One thread for each cell.
@compute @workgroup_size(64)
fn give_photons(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                @builtin(local_invocation_index) local: u32) {
    let at = thread_index(workgroup, workgroups, local);
    if (at > photon_settings.cell_mask) {
        return;
    }
    let length = grid_word(at, GRID_LENGTH);
    let count = atomicLoad(&photon_grid[length]);
    if (count > 0u) {
        atomicStore(&photon_grid[grid_word(at, GRID_FIRST)], atomicAdd(&photon_grid[0], count));
        atomicStore(&photon_grid[length], 0u);
    }
}

// One thread for each photon, and at least one.
@compute @workgroup_size(64)
fn sort_photons(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index == 0u) {
        photons[0] = vec4u(photon_count(), 0u, 0u, 0u);
    }
    if (index >= photon_count()) {
        return;
    }
    let cell = cell_of(index);
    let first = atomicLoad(&photon_grid[grid_word(cell.at, GRID_FIRST)]);
    let at = 1u + 2u * (first + atomicAdd(&photon_grid[grid_word(cell.at, GRID_LENGTH)], 1u));
    let carried = photons_arrived[2u + 2u * index];
    photons[at] = photons_arrived[1u + 2u * index];
    photons[at + 1u] = vec4u(carried.xyz, carried.w | (cell.check << PHOTON_CHECK_SHIFT));
}
