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
//!include irradiance/grid.wgsl
//!include shared/powers.wgsl

@group(0) @binding(51) var<storage, read> irradiance_records: array<vec4u>;
// How many there are; then from word 8 on eight words of each: position, octahedral normal, width of a pixel, a random number.
@group(0) @binding(54) var<storage, read_write> irradiance_candidates: array<atomic<u32>>;

const CANDIDATE_WORDS = 8u;

// The sum of two neighbouring harmonics of a record by their factors: three words hold six numbers.
fn two_harmonics(words: vec3u, first: f32, second: f32) -> vec3f {
    let a = unpack2x16snorm(words.x);
    let b = unpack2x16snorm(words.y);
    let c = unpack2x16snorm(words.z);
    return first * vec3f(a, b.x) + second * vec3f(b.y, c);
}

// How the irradiance changes from place to place: red, green, blue.
struct Gradient {
    red: vec3f,
    green: vec3f,
    blue: vec3f,
}

fn record_gradient(at: u32) -> Gradient {
    let a = bitcast<vec4f>(irradiance_records[at + 3u]);
    let b = bitcast<vec4f>(irradiance_records[at + 4u]);
    return Gradient(a.xyz, vec3f(a.w, b.xy), vec3f(b.zw, bitcast<f32>(irradiance_records[at + 5u].x)));
}

fn along(gradient: Gradient, offset: vec3f) -> vec3f {
    return vec3f(dot(gradient.red, offset), dot(gradient.green, offset), dot(gradient.blue, offset));
}

// The irradiance of a record where it lies, and with another normal, whose harmonics are `toward`.
fn record_irradiance(at: u32, is_turned: bool, toward: array<f32, 9>) -> vec3f {
    var irradiance = bitcast<vec3f>(irradiance_records[at + 1u].xyz);
    if (is_turned) {
        let c = irradiance_records[at + 5u];
        let d = irradiance_records[at + 6u];
        let e = irradiance_records[at + 7u];
        let f = irradiance_records[at + 8u];
        let last = vec3f(unpack2x16snorm(f.y), unpack2x16snorm(f.z).x);
        let all = two_harmonics(c.yzw, 1.0, toward[1]) + two_harmonics(d.xyz, toward[2], toward[3])
            + two_harmonics(vec3u(d.w, e.xy), toward[4], toward[5]) + two_harmonics(vec3u(e.zw, f.x), toward[6], toward[7])
            + toward[8] * last;
        irradiance = all * (MOST_HARMONIC * max_component(irradiance));
    }
    return irradiance;
}

// How much more than what lies beside a record what lies above it counts as far away.
const STEEPNESS = 12.0;
// Normals that are farther apart, as the square of the distance of their ends, are two (0.8 degrees).
const LEAST_TURN2 = 2e-4;

// A sample of the picture asks one in so many references of a cell at most, which counts for these; another one than the sample before,
// so that as many samples have asked all of them.
const MOST_THINNED = 4u;
// So many it asks at least, as far as there are.
const FEW_REFERENCES = 4u;

// What records say of a place.
struct Known {
    irradiance: vec3f, // weighed from all that reach there
    weight: f32, // of all of them
    left: f32, // how much is better left to paths
}

// Of how many references of a cell one is asked, a power of two.
fn thinned_to(count: u32, most: u32) -> u32 {
    var thinned = 1u;
    while (thinned < most && count >= 2u * FEW_REFERENCES * thinned) {
        thinned *= 2u;
    }
    return thinned;
}

// `facing` is the normal by which records are chosen, `normal` the one that light falls on.
//
// On the way from a record to the place the light changes by half of what the gradient there says and half of what it says here (the
// trapezoidal rule), which is about the mean of all. With a record's own gradient alone, light that bends would be wrong by the mean
// square of the distances: a ceiling in the middle of which it is brightest, too bright everywhere. So it is wrong by the square of the mean offset, next to
// nothing where records lie all around.
// What half of a record's rays find more than all is added to it as often as `side_of_half` says: 1 for the samples of the first half, -1 for those of
// the second, 0 where samples don't come in halves.
// One in `most_thinned` references of a cell is asked at least, and which, goes by `turn`.
fn irradiance_at(position: vec3f, facing: vec3f, normal: vec3f, side_of_half: f32, most_thinned: u32, turn: u32) -> Known {
    var sum = vec4f(0.0);
    var differences = vec3f(0.0);
    var left = 0.0;
    var offsets = vec3f(0.0);
    var gradients = Gradient(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    let toward = harmonics(normal);
    let is_bumped = dot(facing, normal) < 1.0 - 0.5 * LEAST_TURN2;
    let coarse_facing = coarse_normal(facing);
    // A weight falls to nothing at the distance of 1.
    let of_turn = irradiance_settings.falloff / FARTHEST_TURN;
    let turn_scale = 0.5 * of_turn * of_turn;
    for (var level = 0u; level < irradiance_settings.levels; level++) {
        let side_log2 = irradiance_settings.first_level + i32(level);
        let side = power_of_two(side_log2);
        let scaled = position * power_of_two(-side_log2);
        let cell = floor(scaled);
        let references = references_of(vec3i(cell), level);
        let thinned = thinned_to(references.y - references.x, most_thinned);
        for (var i = references.x + turn % thinned; i < references.y; i += thinned) {
            let reference = irradiance_references[i];
            let reaches = reference_reach(reference);
            let offset = scaled - cell - reference_place(reference);
            let beside2 = dot(offset, offset);
            if (beside2 >= reaches * reaches) {
                continue;
            }
            let own_facing = reference_facing(reference);
            let turn = coarse_facing - own_facing;
            let turn2 = dot(turn, turn);
            // How far one lies above the other: on a plane and on a ball 0, across a step not.
            let height = (0.5 * STEEPNESS) * dot(offset, coarse_facing + own_facing);
            let apart2 = max(beside2, height * height) / (reaches * reaches);
            let distance2 = max(apart2, turn_scale * turn2);
            if (distance2 < 1.0) {
                let weight = (1.0 - sqrt(distance2)) * f32(thinned);
                let is_turned = is_bumped || turn2 > LEAST_TURN2;
                let at = reference_record(reference);
                left += weight * reference_left(reference);
                let gradient = record_gradient(at);
                let moved = weight * side * offset;
                sum += weight * vec4f(record_irradiance(at, is_turned, toward), 1.0);
                sum += vec4f(0.5 * along(gradient, moved), 0.0);
                differences += weight * bitcast<vec3f>(irradiance_records[at + 2u].xyz);
                offsets += moved;
                gradients.red += weight * gradient.red;
                gradients.green += weight * gradient.green;
                gradients.blue += weight * gradient.blue;
            }
        }
    }
    let scale = 1.0 / max(sum.w, 1e-6);
    let bent = along(gradients, (0.5 * scale) * offsets);
    let irradiance = max((sum.xyz + bent) * scale, vec3f(0.0));
    // Both halves have light: what one has more, the other has less.
    let difference = clamp(differences * scale, -irradiance, irradiance);
    return Known(irradiance + side_of_half * difference, sum.w, left * scale);
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

// Has the path go on where few would have if records had known the place: all do.
fn go_on_whole(slot: u32, left: vec4u) {
    if ((left.w & LEFT_FEW) == 0u) {
        return;
    }
    let share = bitcast<f32>(left.x);
    let light = path_read(PATH_LIGHT, slot);
    path_write(PATH_LIGHT, slot, vec4f(light.xyz * share, light.w));
    if (catches_shadows && left.z == 0u) {
        let caught = path_read(split_field(PATH_CAUGHT), slot);
        path_write(split_field(PATH_CAUGHT), slot, vec4f(caught.xyz, caught.w * share));
    }
    let throughput = path_read(PATH_THROUGHPUT, slot);
    path_write(PATH_THROUGHPUT, slot, vec4f(throughput.xyz, throughput.w / bitcast<f32>(left.y)));
    if (irradiance_settings.photons != 0u) {
        path_set_words(PATH_LEFT, slot, vec4u(shares_words(vec3f(1.0), true, 0u), left.zw));
    }
    if ((left.w & LEFT_ON) != 0u) {
        queue_append(QUEUE_ACTIVE, slot);
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
        go_on_whole(slot, left);
        return;
    }
    let place = path_words(PATH_PLACE, slot);
    let diffuse = path_words(PATH_DIFFUSE, slot);
    let goes_on = (left.w & LEFT_ON) != 0u;
    let facing = octahedral_decode(place.w);
    let in_halves = frame.has_halves != 0u && mode == IRRADIANCE_USE;
    let id = path_id(slot);
    let side_of_half = select(0.0, select(-1.0, 1.0, is_first_half(id.number)), in_halves);
    // Each pixel begins with a turn of its own, or pictures of one sample would show the cells.
    let turn = id.number + id.key;
    var found: Known;
    // Where what one sample asks hardly reaches, it asks all.
    for (var most_thinned = select(1u, MOST_THINNED, mode == IRRADIANCE_USE);; most_thinned = 1u) {
        found = irradiance_at(bitcast<vec3f>(place.xyz), facing, octahedral_decode(diffuse.w), side_of_half, most_thinned, turn);
        if (most_thinned == 1u || found.weight >= LEAST_WEIGHT) {
            break;
        }
    }
    let gathered = path_read(PATH_RADIANCE, slot);
    if (mode == IRRADIANCE_FIND) {
        if (found.weight < LEAST_WEIGHT) {
            add_candidate(slot, place, gathered.w);
        }
        if (goes_on) {
            end_path(slot);
        }
        return;
    }
    let chances = random2(id, vertex_dimension(left.z, DIMENSION_HUE));
    if (found.weight <= 0.0 || chances.x < found.left * irradiance_settings.left) {
        go_on_whole(slot, left);
        return; // the path finds it out by itself
    }
    let scattered = limited(bitcast<vec3f>(diffuse.xyz) * found.irradiance, f32(left.z + 2u));
    path_write(PATH_RADIANCE, slot, vec4f(gathered.xyz + scattered, gathered.w));
    if (has_photons) {
        // Where the path has come by way of casters, this is no light that photons may have brought.
        let kept = path_words(irradiance_settings.photons, slot);
        path_set_words(irradiance_settings.photons, slot, vec4u(bitcast<vec3u>(bitcast<vec3f>(kept.xyz) + scattered), kept.w));
    }
    if (splits_light) {
        let word = found_word(left.z + 2u, true, NO_GROUP) | select(0u, FOUND_GIVEN, left.z == 0u);
        path_set_words(path_given(), slot, vec4u(bitcast<vec3u>(scattered), word));
    }
    if (!goes_on) {
        return;
    }
    // The ray stands for one part or for the other, each as often as that carries more.
    let are_few = (left.w & LEFT_FEW) != 0u;
    let few = bitcast<f32>(left.y);
    var share = vec3f(1.0);
    if (are_few) {
        if (chances.y >= few) {
            // No shadow ray of it waits for a texture program, see `Lamps` of `renderer/irradiance/sky.rs`. What its light sample brings
            // this vertex alone has scattered.
            let state = path_words(PATH_STATE, slot);
            path_set_words(PATH_STATE, slot, vec4u(state.xy, left.z, state.w));
            return;
        }
        queue_append(QUEUE_ACTIVE, slot);
    } else {
        share = shares_diffuse(left.xy);
    }
    let throughput = path_read(PATH_THROUGHPUT, slot);
    let whole = max(max_component(throughput.xyz), 1e-37);
    let probability = select(clamp(max_component(throughput.xyz * share) / whole, 0.0, 1.0), few, are_few);
    let is_diffuse = chances.y < probability;
    if (is_diffuse) {
        path_write(PATH_THROUGHPUT, slot, vec4f(throughput.xyz * share / probability, throughput.w));
        let state = path_words(PATH_STATE, slot);
        path_set_words(PATH_STATE, slot, vec4u(state.xy, state.z | PATH_ENDS, state.w));
    } else {
        let rest = (vec3f(1.0) - share) / max(1.0 - probability, 1e-6);
        path_write(PATH_THROUGHPUT, slot, vec4f(throughput.xyz * rest, throughput.w));
    }
    if (splits_light && left.z == 0u && !are_few && any(share < vec3f(1.0))) {
        // From now on all that the path finds the first surface has scattered one way.
        let former = path_words(split_field(PATH_SHARES), slot);
        let is_above = (former.w & SHARES_ABOVE) != 0u;
        let words = shares_words(select(vec3f(0.0), vec3f(1.0), is_diffuse), is_above, 0u);
        path_set_words(split_field(PATH_SHARES), slot, vec4u(former.xy, words));
    }
    if (has_photons) {
        let stands_for = select(vec3f(0.0), vec3f(1.0), is_diffuse);
        path_set_words(PATH_LEFT, slot, vec4u(shares_words(stands_for, true, 0u), left.zw));
    }
}
