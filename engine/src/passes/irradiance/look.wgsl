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

// Two words for each part of the sky in each cell, and for all lamps together: samples, and those that arrived. Then the row of the wider
// cell around it, and the facing, plus one each.
@group(0) @binding(64) var<storage, read_write> sky_seen: array<atomic<u32>>;

const SKY_COUNTS = SKY_PARTS + 2u;
// How much wider that one is: where too little is known of a cell, it helps out.
const WIDER_SKY = 4.0;

// The part of the sky in a direction.
fn part_towards(direction: vec3f) -> u32 {
    let cell = vec2u(environment_uv(direction) * vec2f(frame.distribution_size));
    return sky_part(min(cell, frame.distribution_size - 1u));
}

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
    var part = SKY_PARTS;
    if (ray.t_max >= FAR && !is_of_distant_lamp(ray.direction)) {
        part = part_towards(ray.direction);
    }
    let receiver = path_words(PATH_LIGHT, slot).w;
    let cell = sky_row(ray.origin, receiver, path_id(slot)) * SKY_COUNTS;
    let wider = wider_sky_row(ray.origin, path_id(slot), WIDER_SKY);
    atomicMax(&sky_seen[2u * (cell + SKY_PARTS + 1u)], wider + 1u);
    atomicMax(&sky_seen[2u * (cell + SKY_PARTS + 1u) + 1u], receiver_facing(receiver, CELL_FACING_STEPS) + 1u);
    count(2u * (cell + part), ray.triangle == MISS);
    count(2u * (wider * SKY_COUNTS + part), ray.triangle == MISS);
}

fn count(at: u32, arrives: bool) {
    atomicAdd(&sky_seen[at], 1u);
    if (arrives) {
        atomicAdd(&sky_seen[at + 1u], 1u);
    }
}
