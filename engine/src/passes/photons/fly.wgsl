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

// What a photon's two fields hold, of a path's state. Before a caster has scattered it: the range of its lamp, or 0; what that leaves of its
// light; 1 + the material of a body that it began in, or 0; 0. Where it has arrived from a caster and the surface has yet to be shaded:
// its flux as whole numbers, then PHOTON_WAITS and how many casters have scattered it; position and octahedral normal.
const PHOTON_WAITS = 0x100u;

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
    let s = surface_at(hit);
    let material = s.triangle.w & TRIANGLE_MATERIAL;
    let is_back = has_transmission && !s.front && (materials[material].flags & MATERIAL_SOLID) != 0u;
    let media = path_words(PATH_MEDIA, slot);
    let began_inside = is_back && !media_hold(media, material);
    let range = path_words(photon_settings.field, slot).x;
    // KHR_lights_punctual: a window that falls to zero at the range.
    let ratio = select(0.0, hit.t_max / bitcast<f32>(range), range != 0u);
    let window = saturate(1.0 - ratio * ratio * ratio * ratio);
    path_set_words(photon_settings.field, slot, vec4u(range, bitcast<u32>(window), select(0u, material + 1u, began_inside), 0u));
    let scattered = path_depth(slot);
    let is_inside = is_back || (has_transmission && medium_among(media) != 0u);
    if (scattered == 0u || is_inside || is_caster_throughout(material)) {
        return;
    }
    let number = hash2(hash2(frame.first_sample * frame.padded_pixels + frame.first_pixel + slot, scattered), photon_settings.seed);
    let carried = path_read(PATH_THROUGHPUT, slot);
    path_set_words(photon_settings.field, slot,
        vec4u(whole_flux(carried.x, number), whole_flux(carried.y, number + 1u), whole_flux(carried.z, number + 2u), PHOTON_WAITS | scattered));
    path_set_words(photon_settings.field + 1u, slot, vec4u(bitcast<vec3u>(s.position), octahedral_encode(s.geometric_normal)));
}

// Keeps a photon that waits; those for which there is no room are lost.
fn keep_photon(slot: u32, flux: vec4u) {
    let at = atomicAdd(&photons_arrived[0], 1u);
    if (at >= photon_settings.photons) {
        return;
    }
    let place = path_words(photon_settings.field + 1u, slot);
    let words = array<u32, 8>(place.x, place.y, place.z, place.w, flux.x, flux.y, flux.z, flux.w & ~PHOTON_WAITS);
    for (var i = 0u; i < PHOTON_WORDS; i++) {
        atomicStore(&photons_arrived[4u + PHOTON_WORDS * at + i], words[i]);
    }
}

// By what a photon counts for less once its first caster has scattered it.
fn lessened(kept: vec4u, slot: u32) -> f32 {
    let window = select(1.0, bitcast<f32>(kept.y), kept.x != 0u);
    if (!has_transmission || kept.z == 0u) {
        return window;
    }
    // The surface scatters radiance, which is denser inside by the square of the index. What goes in and out again has the same in the
    // end; what began inside has not, and flux is no denser anywhere.
    let hue = path_read(PATH_STATE, slot).w;
    let m = kept.z - 1u;
    let index = dispersed(max(materials[m].ior, 1.0), materials[m].dispersion, select(hue - HUE_OFFSET, 0.5, hue == 0.0));
    return window / (index * index);
}

// After the surface has scattered it: what a caster has not is kept where it waits. One thread for each photon that was active.
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
    let kept = path_words(photon_settings.field, slot);
    let waits = (kept.w & PHOTON_WAITS) != 0u;
    if (waits && kind != LEFT_CASTER) {
        keep_photon(slot, kept);
    }
    if (waits || kind == LEFT_CASTER) {
        path_set_words(photon_settings.field, slot, vec4u(0u));
    }
    if (kind == LEFT_NONE || kind == LEFT_SKY) {
        return; // it has passed, or is gone
    }
    if (kind != LEFT_CASTER) {
        end_path(slot);
    } else if (!waits) {
        let carried = path_read(PATH_THROUGHPUT, slot);
        path_write(PATH_THROUGHPUT, slot, vec4f(carried.xyz * lessened(kept, slot), carried.w));
    }
}
