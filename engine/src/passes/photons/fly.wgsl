// Photons on their way: where they arrive from a caster they are kept, and only casters scatter them further.
//!include shared/wave_memory.wgsl
//!include shared/ends.wgsl
//!include shared/queue_lists.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/media.wgsl
//!include shared/surface.wgsl
//!include shared/abilities.wgsl
//!include shared/left.wgsl
//!include photons/records.wgsl

@group(0) @binding(58) var<storage, read_write> photons_arrived: array<atomic<u32>>;

// Whether nothing of the surface can scatter diffusely, so that no path asks for photons there.
fn is_caster_throughout(material: u32) -> bool {
    let textures = (1u << TEXTURE_METALLIC_ROUGHNESS) | (1u << (FIRST_LAYER_TEXTURE + LAYER_TRANSMISSION));
    return (materials[material].flags & (MATERIAL_CASTER | MATERIAL_PROGRAM)) == MATERIAL_CASTER
        && (materials[material].texture_mask & textures) == 0u;
}

// A whole number that is the flux on average.
fn whole_flux(flux: f32, number: u32) -> u32 {
    return u32(clamp(flux * FLUX_SCALE + unit_number(hash(number)), 0.0, 1e9));
}

// Where a photon has arrived, before the surface scatters it. One thread for each of them.
@compute @workgroup_size(64)
fn photon_arrive(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                 @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let hit = rays[own_ray(slot)];
    if (hit.triangle == MISS) {
        return;
    }
    let scattered = path_depth(slot);
    let carried = path_read(PATH_THROUGHPUT, slot);
    if (scattered == 0u) {
        // KHR_lights_punctual: a window that falls to zero at the range.
        let range = path_read(photon_settings.field, slot).x;
        if (range > 0.0) {
            let ratio = hit.t_max / range;
            path_write(PATH_THROUGHPUT, slot, vec4f(carried.xyz * saturate(1.0 - ratio * ratio * ratio * ratio), carried.w));
            path_write(photon_settings.field, slot, vec4f(0.0));
        }
        return;
    }
    let s = surface_at(hit);
    let material = s.triangle.w & TRIANGLE_MATERIAL;
    let is_inside = has_transmission
        && (medium_among(path_words(PATH_MEDIA, slot)) != 0u || (!s.front && (materials[material].flags & MATERIAL_SOLID) != 0u));
    if (is_inside || is_caster_throughout(material)) {
        return;
    }
    let at = atomicAdd(&photons_arrived[0], 1u);
    if (at >= photon_settings.photons) {
        return;
    }
    let number = hash2(hash2(frame.first_sample * frame.padded_pixels + frame.first_pixel + slot, scattered), photon_settings.seed);
    let place = bitcast<vec3u>(s.position);
    let words = array<u32, 8>(place.x, place.y, place.z, octahedral_encode(s.geometric_normal), whole_flux(carried.x, number),
        whole_flux(carried.y, number + 1u), whole_flux(carried.z, number + 2u), scattered);
    for (var i = 0u; i < PHOTON_WORDS; i++) {
        atomicStore(&photons_arrived[4u + PHOTON_WORDS * at + i], words[i]);
    }
}

// After the surface has scattered it. One thread for each photon that was active.
@compute @workgroup_size(64)
fn photon_follow(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                 @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let left = path_words(PATH_LEFT, slot);
    path_set_words(PATH_LEFT, slot, vec4u(0u));
    let kind = left.w & LEFT_KIND;
    if (kind == LEFT_NONE || kind == LEFT_SKY) {
        return; // it has passed, or is gone
    }
    if (kind != LEFT_CASTER) {
        end_path(slot);
    }
}
