// Takes what a surface scatters diffusely from the cache of irradiance, or finds places that it doesn't know. One thread for each
// active path, whose vertex has been shaded.
//
// What the records give is light that two surfaces or more have scattered. The path's own ray goes on with what else the surface
// scatters; where chance has it stand for the diffuse part it only has to find lamps and the sky, which no record knows, and ends
// with that.
//!include shared/wave_memory.wgsl
//!include shared/ends.wgsl
//!include shared/queue_lists.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/found_light.wgsl
//!include shared/left.wgsl
//!include irradiance/records.wgsl
//!include shared/powers.wgsl

@group(0) @binding(51) var<storage, read> irradiance_records: array<vec4u>;
// Cells of a grid of several levels, found by a hash: a number by which the cell is known, or 0 where the slot is free; its first
// reference, and how many. Then the references: records that reach into the cell.
@group(0) @binding(52) var<storage, read> irradiance_grid: array<vec4u>;
@group(0) @binding(53) var<storage, read> irradiance_references: array<u32>;
// How many there are; then from word 8 on eight words of each: position, octahedral normal, width of a pixel, a random number.
@group(0) @binding(54) var<storage, read_write> irradiance_candidates: array<atomic<u32>>;

const CANDIDATE_WORDS = 8u;

// Slots that are looked at for a cell.
const GRID_PROBES = 64u;

// The number by which a cell is known; `renderer/irradiance/grid.rs` has the same. Never 0.
fn cell_number(cell: vec3i, level: u32) -> u32 {
    let place = hash2(hash2(hash2(hash(level), bitcast<u32>(cell.x)), bitcast<u32>(cell.y)), bitcast<u32>(cell.z));
    return max(place, 1u);
}

// First reference of a cell, and behind its last.
fn references_of(cell: vec3i, level: u32) -> vec2u {
    let number = cell_number(cell, level);
    for (var i = 0u; i < GRID_PROBES; i++) {
        let slot = irradiance_grid[(number + i) & irradiance_settings.mask];
        if (slot.x == number) {
            return vec2u(slot.y, slot.y + slot.z);
        }
        if (slot.x == 0u) {
            break;
        }
    }
    return vec2u(0u);
}

// The sum of two neighbouring harmonics of a record by their factors: three words hold six numbers.
fn two_harmonics(words: vec3u, first: f32, second: f32) -> vec3f {
    let a = unpack2x16snorm(words.x);
    let b = unpack2x16snorm(words.y);
    let c = unpack2x16snorm(words.z);
    return first * vec3f(a, b.x) + second * vec3f(b.y, c);
}

// The irradiance of a record at a place, and with another normal, whose harmonics are `toward`.
fn record_irradiance(at: u32, own: vec4u, offset: vec3f, is_turned: bool, toward: array<f32, 9>) -> vec3f {
    let a = bitcast<vec4f>(irradiance_records[at + 2u]);
    let b = bitcast<vec4f>(irradiance_records[at + 3u]);
    let c = irradiance_records[at + 4u];
    let moved = vec3f(dot(offset, a.xyz), dot(offset, vec3f(a.w, b.xy)), dot(offset, vec3f(b.zw, bitcast<f32>(c.x))));
    var irradiance = bitcast<vec3f>(own.xyz);
    if (is_turned) {
        let d = irradiance_records[at + 5u];
        let e = irradiance_records[at + 6u];
        let f = irradiance_records[at + 7u];
        let last = vec3f(unpack2x16snorm(f.y), unpack2x16snorm(f.z).x);
        let all = two_harmonics(c.yzw, 1.0, toward[1]) + two_harmonics(d.xyz, toward[2], toward[3])
            + two_harmonics(vec3u(d.w, e.xy), toward[4], toward[5]) + two_harmonics(vec3u(e.zw, f.x), toward[6], toward[7])
            + toward[8] * last;
        irradiance = all * (MOST_HARMONIC * max_component(irradiance));
    }
    return max(irradiance + moved, vec3f(0.0));
}

// How much more than what lies beside a record what lies above it counts as far away.
const STEEPNESS = 12.0;

// The irradiance at a place, weighed from all records that reach there, and the sum of their weights. `facing` is the normal by
// which records are chosen, `normal` the one that light falls on.
fn irradiance_at(position: vec3f, facing: vec3f, normal: vec3f) -> vec4f {
    var sum = vec4f(0.0);
    let toward = harmonics(normal);
    let reach = 1.0 / irradiance_settings.falloff;
    let reach2 = reach * reach;
    for (var level = 0u; level < irradiance_settings.levels; level++) {
        let side = power_of_two(irradiance_settings.first_level + i32(level));
        let references = references_of(vec3i(floor(position / side)), level);
        for (var i = references.x; i < references.y; i++) {
            let at = irradiance_references[i] * RECORD_WORDS;
            let place = bitcast<vec4f>(irradiance_records[at]);
            let offset = position - place.xyz;
            let radius = place.w;
            if (dot(offset, offset) >= radius * radius * reach2) {
                continue;
            }
            let own = irradiance_records[at + 1u];
            let own_normal = octahedral_decode(own.w);
            let turn = sqrt(max(1.0 - dot(facing, own_normal), 0.0)) / FARTHEST_TURN;
            // How far one lies above the other: on a plane and on a ball 0, across a step not.
            let height = abs(dot(offset, facing + own_normal)) * 0.5;
            let apart = max(length(offset), STEEPNESS * height) / radius;
            let weight = 1.0 - irradiance_settings.falloff * max(apart, turn);
            if (weight > 0.0) {
                let is_turned = dot(own_normal, normal) < 0.9999;
                sum += weight * vec4f(record_irradiance(at, own, offset, is_turned, toward), 1.0);
            }
        }
    }
    return vec4f(sum.xyz / max(sum.w, 1e-6), sum.w);
}

// Weights that a place needs to be covered.
const LEAST_WEIGHT = 0.15;

// Notes a place for a new record, by chance.
fn add_candidate(slot: u32, place: vec4u, width: f32) {
    let id = path_id(slot);
    let number = hash2(id.key, 0x6c8e9cf5u + id.sample);
    if (unit_number(number) >= irradiance_settings.share) {
        return;
    }
    let at = atomicAdd(&irradiance_candidates[0], 1u);
    if (at >= irradiance_settings.candidates) {
        return;
    }
    let words = array<u32, 6>(place.x, place.y, place.z, place.w, bitcast<u32>(width), hash(number));
    for (var i = 0u; i < 6u; i++) {
        atomicStore(&irradiance_candidates[CANDIDATE_WORDS * (at + 1u) + i], words[i]);
    }
}

@compute @workgroup_size(64)
fn look_up_irradiance(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                      @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let left = path_words(PATH_LEFT, slot);
    if (left.w == LEFT_NONE) {
        return;
    }
    let has_photons = irradiance_settings.photons != 0u; // whose pass comes next
    if (!has_photons) {
        path_set_words(PATH_LEFT, slot, vec4u(0u));
    }
    if ((left.w & LEFT_KIND) != LEFT_DIFFUSE) {
        return;
    }
    let mode = irradiance_settings.mode;
    // Of what surfaces scatter diffusely here, another one must have scattered it before.
    if (mode == IRRADIANCE_IDLE || left.z + 2u > frame.max_depth) {
        return;
    }
    let place = path_words(PATH_PLACE, slot);
    let diffuse = path_words(PATH_DIFFUSE, slot);
    let goes_on = (left.w & LEFT_ON) != 0u;
    let facing = octahedral_decode(place.w);
    let found = irradiance_at(bitcast<vec3f>(place.xyz), facing, octahedral_decode(diffuse.w));
    let gathered = path_read(PATH_RADIANCE, slot);
    if (mode == IRRADIANCE_FIND) {
        if (found.w < LEAST_WEIGHT) {
            add_candidate(slot, place, gathered.w);
        }
        if (goes_on) {
            end_path(slot);
        }
        return;
    }
    if (found.w <= 0.0) {
        return; // the path finds it out by itself
    }
    let scattered = limited(bitcast<vec3f>(diffuse.xyz) * found.xyz, f32(left.z + 2u));
    path_write(PATH_RADIANCE, slot, vec4f(gathered.xyz + scattered, gathered.w));
    if (!goes_on) {
        return;
    }
    // The ray stands for one part or for the other, each as often as that carries more.
    let share = shares_diffuse(left.xy);
    let throughput = path_read(PATH_THROUGHPUT, slot);
    let whole = max(max_component(throughput.xyz), 1e-37);
    let probability = clamp(max_component(throughput.xyz * share) / whole, 0.0, 1.0);
    let is_diffuse = random2(path_id(slot), vertex_dimension(left.z, DIMENSION_HUE)).y < probability;
    if (is_diffuse) {
        path_write(PATH_THROUGHPUT, slot, vec4f(throughput.xyz * share / probability, throughput.w));
        let state = path_words(PATH_STATE, slot);
        path_set_words(PATH_STATE, slot, vec4u(state.xy, frame.max_depth, state.w));
    } else {
        let rest = (vec3f(1.0) - share) / max(1.0 - probability, 1e-6);
        path_write(PATH_THROUGHPUT, slot, vec4f(throughput.xyz * rest, throughput.w));
    }
    if (has_photons) {
        let stands_for = select(vec3f(0.0), vec3f(1.0), is_diffuse);
        path_set_words(PATH_LEFT, slot, vec4u(shares_words(stands_for, true, 0u), left.zw));
    }
}
