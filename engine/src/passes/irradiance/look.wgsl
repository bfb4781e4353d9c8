// Looks where the sky is seen: counts light samples that have been sent there, and those that nothing was in the way of. One thread
// for each shadow ray, which has been traced.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include shared/microfacet.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/lights.wgsl
//!include shared/estimator.wgsl
//!include shared/random.wgsl

// Two words for each part of the sky in each cell, and for all lamps together: samples, and those that arrived. Then the row of the wider
// cell around it, and the facing, plus one each. Then words: how much light has arrived by way of no opening, and of each of them; and
// of how many samples. Behind all cells, for each square of the box's sides: samples that have arrived by way of it before that was known.
@group(0) @binding(64) var<storage, read_write> sky_seen: array<atomic<u32>>;

const SKY_COUNTS = SKY_PARTS + 2u + (OPENINGS + 2u) / 2u;
const FIRST_SUM = 2u * (SKY_PARTS + 2u);
const SAMPLE_COUNT = FIRST_SUM + OPENINGS + 1u;
const FIRST_SQUARE = 2u * SKY_CELLS * SKY_COUNTS;
// Of a sample that brings as much as it would without knowing anything, from straight above.
const WHOLE_SUM = 1024.0;
const MOST_BROUGHT = 64.0;
// What is so many times as bright as the sky's mean is found by parts: beside a sun all else is little, and an opening doesn't know where
// in it that is.
const MOST_BRIGHT = 16.0;
// How much wider that one is: where too little is known of a cell, it helps out.
const WIDER_SKY = 4.0;

// Whether a lamp infinitely far away lies there.
fn is_of_distant_lamp(direction: vec3f) -> bool {
    for (var i = 0u; i < frame.directional_count; i++) {
        let light = light_at(frame.light_count + i);
        let off = direction + light.direction;
        if (0.5 * dot(off, off) <= 1.0001 * light.position[DISTANT_EXTENT] + 1e-9) {
            return true;
        }
    }
    return false;
}

@compute @workgroup_size(64)
fn look_for_sky(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_SHADOW)) {
        return;
    }
    let slot = queue_read(QUEUE_SHADOW, index);
    let ray = rays[shadow_ray(slot)];
    let arrives = ray.triangle == MISS;
    let receiver = path_words(PATH_LIGHT, slot).w;
    let id = path_id(slot);
    let row = sky_row(ray.origin, receiver, id);
    let cell = 2u * row * SKY_COUNTS;
    let wider_row = wider_sky_row(ray.origin, id, WIDER_SKY);
    let wider = 2u * wider_row * SKY_COUNTS;
    atomicMax(&sky_seen[cell + 2u * (SKY_PARTS + 1u)], wider_row + 1u);
    atomicMax(&sky_seen[cell + 2u * (SKY_PARTS + 1u) + 1u], receiver_facing(receiver, CELL_FACING_STEPS) + 1u);
    if (ray.t_max < FAR || is_of_distant_lamp(ray.direction)) {
        count(cell + 2u * SKY_PARTS, arrives);
        count(wider + 2u * SKY_PARTS, arrives);
        return;
    }
    let exit = exit_of(ray.origin, ray.direction);
    let uv = environment_uv(ray.direction);
    let texel = min(vec2u(uv * vec2f(frame.distribution_size)), frame.distribution_size - 1u);
    var by_parts = 1.0;
    if (sky_is_known()) {
        let share = openings_share(row);
        by_parts = (1.0 - share) * parts_pdf_at(uv, ray.direction, row);
        let opening = opening_at(exit);
        let pdf = by_parts + share * opening_pdf(exit, opening, row);
        by_parts /= pdf;
        atomicAdd(&sky_seen[cell + SAMPLE_COUNT], 1u);
        if (arrives) {
            let sent = cell_pdf(texel, polar_sine(ray.direction));
            let at = FIRST_SUM + select(opening, 0u, sent * (4.0 * PI) > MOST_BRIGHT);
            atomicAdd(&sky_seen[cell + at], brings(ray.direction, receiver, sent / pdf));
        }
    } else if (arrives) {
        let square = exit_square(exit);
        atomicAdd(&sky_seen[FIRST_SQUARE + square.y * EXIT_SQUARES + square.x], 1u);
    }
    // Of samples through openings too few end at a frame: only those count that may have been sent to the part.
    if (unit_number(hash2(id.key, hash2(id.sample, bitcast<u32>(ray.direction.x)))) < by_parts) {
        let part = sky_part(texel);
        count(cell + 2u * part, arrives);
        count(wider + 2u * part, arrives);
    }
}

fn count(at: u32, arrives: bool) {
    atomicAdd(&sky_seen[at], 1u);
    if (arrives) {
        atomicAdd(&sky_seen[at + 1u], 1u);
    }
}

// What a sample that has arrived brings, over all that the sky sends; `sent` is how much of that comes from its direction over how likely
// it was sent there.
fn brings(direction: vec3f, receiver: u32, sent: f32) -> u32 {
    let normal = receiver_normal(receiver);
    let cosine = select(max(dot(normal, direction), 0.0), 1.0, all(normal == vec3f(0.0)));
    return u32(min(cosine * sent, MOST_BROUGHT) * WHOLE_SUM + 0.5);
}
