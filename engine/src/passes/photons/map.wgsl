// Builds the octree of the photons, all at once: references to the leaves that photons reach into are counted, places for them are
// given out, and they are put down. No passes of a wave.
//!include photons/records.wgsl
//!include shared/rays.wgsl
//!include shared/geometry.wgsl

// Before the cells a header of four words: references given out, and references counted.
@group(0) @binding(59) var<storage, read_write> photon_cells: array<atomic<u32>>;
@group(0) @binding(60) var<storage, read_write> photon_references: array<u32>;
@group(0) @binding(62) var<storage, read> photons: array<vec4u>;

const CELL_WORDS = 4u;
const CELL_COUNT = 0u;
const CELL_IS_SPLIT = 1u;
const CELL_FIRST = 2u;
const CELL_LENGTH = 3u;

const WORD_GIVEN = 0u;
const WORD_COUNTED = 1u;

fn cell_word(at: u32, word: u32) -> u32 {
    return CELL_WORDS * (at + 1u) + word;
}

struct Photon {
    position: vec3f,
    normal: vec3f,
    reach: f32, // of any place that it counts for
}

fn photon_at(index: u32) -> Photon {
    let words = photons[1u + 2u * index];
    let position = bitcast<vec3f>(words.xyz);
    var reach = photon_radius(position);
    if (frame.orthographic == 0u) {
        // A place farther away from the camera reaches farther.
        reach /= 1.0 - min(photon_settings.radius, 0.5);
    }
    return Photon(position, octahedral_decode(words.w), reach * 1.001);
}

// Whether the photon's disk, as thick as places may lie above it, reaches into a cell.
fn reaches(photon: Photon, corner: vec3f, side: f32) -> bool {
    let nearest = clamp(photon.position, corner, corner + side);
    let off = nearest - photon.position;
    let middle = corner + 0.5 * side - photon.position;
    let across = 0.5 * side * dot(abs(photon.normal), vec3f(1.0));
    return dot(off, off) <= photon.reach * photon.reach
        && abs(dot(middle, photon.normal)) <= across + MOST_HEIGHT * photon.reach;
}

// Comes to each leaf that the photon reaches into, and counts the reference there, or puts it down. How many there are.
fn visit(index: u32, puts_down: bool) -> u32 {
    let photon = photon_at(index);
    let distance = length(photon.position - frame.camera_position);
    var nearest = photon_settings.radius;
    var farthest = photon_settings.radius;
    if (frame.orthographic == 0u) {
        nearest *= max(distance - photon.reach, photon_settings.nearest);
        farthest *= max(distance + photon.reach, photon_settings.nearest);
    }
    var leaves = 0u;
    var stack: array<vec4i, 16>; // 8 for each level, but for the last of each
    for (var root = root_level(nearest); root <= root_level(farthest); root++) {
        let low = vec3i(floor((photon.position - photon.reach) / side_of(root)));
        let size = vec3i(floor((photon.position + photon.reach) / side_of(root))) - low + 1;
        for (var i = 0; i < size.x * size.y * size.z; i++) {
            stack[0] = vec4i(low + vec3i(i % size.x, (i / size.x) % size.y, i / (size.x * size.y)), 0);
            var height = 1u;
            while (height > 0u) {
                height--;
                let cell = stack[height].xyz;
                let depth = u32(stack[height].w);
                let side = side_of(root - depth);
                if (!reaches(photon, vec3f(cell) * side, side)) {
                    continue;
                }
                let found = map_cell(root, depth, cell);
                if (depth < MAP_DEPTH && atomicLoad(&photon_cells[cell_word(found.at, CELL_IS_SPLIT)]) != 0u) {
                    for (var child = 0; child < 8; child++) {
                        let offset = vec3i(child & 1, (child >> 1u) & 1, child >> 2u);
                        stack[height] = vec4i(2 * cell + offset, i32(depth) + 1);
                        height++;
                    }
                    continue;
                }
                leaves++;
                let before = atomicAdd(&photon_cells[cell_word(found.at, CELL_COUNT)], 1u);
                if (puts_down) {
                    let at = atomicLoad(&photon_cells[cell_word(found.at, CELL_FIRST)]) + before;
                    if (at < photon_settings.references) {
                        photon_references[at] = index | (found.check << REFERENCE_SHIFT);
                    }
                }
            }
        }
    }
    return leaves;
}

// Whether there is no room for what was counted.
fn is_too_much() -> bool {
    return atomicLoad(&photon_cells[WORD_COUNTED]) > photon_settings.references;
}

fn photon_count() -> u32 {
    return photons[0].x;
}

// Cells that had too many references the last time are split from now on, and all are empty: where photons lie changes little from
// one map to the next, and what a place finds doesn't depend on how cells are split. One thread for each cell.
@compute @workgroup_size(64)
fn split_cells(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
               @builtin(local_invocation_index) local: u32) {
    let at = thread_index(workgroup, workgroups, local);
    if (at > photon_settings.cell_mask) {
        return;
    }
    if (at == 0u) {
        atomicStore(&photon_cells[WORD_GIVEN], 0u);
        atomicStore(&photon_cells[WORD_COUNTED], 0u);
    }
    let length = cell_word(at, CELL_LENGTH);
    if (atomicLoad(&photon_cells[length]) > LEAF_MOST) {
        atomicStore(&photon_cells[cell_word(at, CELL_IS_SPLIT)], 1u);
    }
    atomicStore(&photon_cells[length], 0u);
    atomicStore(&photon_cells[cell_word(at, CELL_COUNT)], 0u);
}

// One thread for each photon.
@compute @workgroup_size(64)
fn count_leaves(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index < photon_count()) {
        atomicAdd(&photon_cells[WORD_COUNTED], visit(index, false));
    }
}

// If there is no room for so many references, no cell is split. One thread for each cell.
@compute @workgroup_size(64)
fn join_cells(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
              @builtin(local_invocation_index) local: u32) {
    let at = thread_index(workgroup, workgroups, local);
    if (at <= photon_settings.cell_mask && is_too_much()) {
        atomicStore(&photon_cells[cell_word(at, CELL_IS_SPLIT)], 0u);
        atomicStore(&photon_cells[cell_word(at, CELL_COUNT)], 0u);
    }
}

// And all is counted anew. One thread for each photon.
@compute @workgroup_size(64)
fn count_again(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
               @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index < photon_count() && is_too_much()) {
        _ = visit(index, false);
    }
}

// Places for the references of each leaf. One thread for each cell.
@compute @workgroup_size(64)
fn give_places(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
               @builtin(local_invocation_index) local: u32) {
    let at = thread_index(workgroup, workgroups, local);
    if (at > photon_settings.cell_mask) {
        return;
    }
    let count = atomicLoad(&photon_cells[cell_word(at, CELL_COUNT)]);
    if (count == 0u) {
        return;
    }
    let first = atomicAdd(&photon_cells[WORD_GIVEN], count);
    let room = photon_settings.references - min(first, photon_settings.references);
    atomicStore(&photon_cells[cell_word(at, CELL_FIRST)], first);
    atomicStore(&photon_cells[cell_word(at, CELL_LENGTH)], min(count, room));
    atomicStore(&photon_cells[cell_word(at, CELL_COUNT)], 0u);
}

// One thread for each photon.
@compute @workgroup_size(64)
fn put_down(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
            @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index < photon_count()) {
        _ = visit(index, true);
    }
}
