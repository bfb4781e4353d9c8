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
//!include shared/hit.wgsl
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

// Of a surface with alpha that photons still are weighed by.
const LEAST_COVERAGE = 1.0 / 256.0;

// How far above its triangle paths ask for photons; see `ray_origins`.
fn curved(s: Surface, material: u32) -> vec3f {
    let passes = has_transmission && max(materials[material].transmission, materials[material].diffuse_transmission) > 0.0;
    return select(s.lift, vec3f(0.0), passes);
}

// A place of a triangle, with its lift, from the first vertex and in the object; see `surface_at`.
fn lifted(edge1: vec3f, edge2: vec3f, normals: mat3x3f, weights: vec2f) -> vec3f {
    let inside = edge1 * weights.x + edge2 * weights.y;
    return inside + lift_by(inside, normals[0], 1.0 - weights.x - weights.y)
        + lift_by(inside - edge1, normals[1], weights.x) + lift_by(inside - edge2, normals[2], weights.y);
}

// How much larger the curved surface around a place is than the triangle below it: photons lie as much farther apart there.
fn stretch(hit: RayHit, s: Surface) -> f32 {
    let world_from_object = instances[hit.instance].world_from_object;
    let va = vertices[s.triangle.x];
    let vb = vertices[s.triangle.y];
    let vc = vertices[s.triangle.z];
    let a = bitcast<vec3f>(va.xyz);
    let edge1 = bitcast<vec3f>(vb.xyz) - a;
    let edge2 = bitcast<vec3f>(vc.xyz) - a;
    let side = select(-1.0, 1.0, s.front);
    let normals = mat3x3f(side * octahedral_decode(va.w), side * octahedral_decode(vb.w), side * octahedral_decode(vc.w));
    // By small steps to both sides: the lift is of the second degree along most of a triangle.
    let step = 1.0 / 64.0;
    let at = s.weights.yz;
    let along1 = lifted(edge1, edge2, normals, at + vec2f(step, 0.0)) - lifted(edge1, edge2, normals, at - vec2f(step, 0.0));
    let along2 = lifted(edge1, edge2, normals, at + vec2f(0.0, step)) - lifted(edge1, edge2, normals, at - vec2f(0.0, step));
    let area = length(cross(transform_vector(world_from_object, along1), transform_vector(world_from_object, along2)));
    return clamp(area / (4.0 * step * step * max(s.area_scale, 1e-30)), 0.25, 4.0);
}

// What a photon's two fields hold, of a path's state. Before a caster has scattered it: the range of its lamp, or 0; what that leaves of its
// light; 1 + the material of the body that it began in, or 0; 0. Where it has arrived from a caster and the surface has yet to be shaded:
// its flux, then PHOTON_WAITS, how many casters have scattered it, and where it comes from; position and octahedral normal.
const PHOTON_WAITS = 0x100u;

// A direction in the upper bits of that word: both octahedral coordinates without their last five bits.
fn with_direction(word: u32, direction: vec3f) -> u32 {
    let coordinates = octahedral_encode(direction);
    return word | (((coordinates >> 5u) & 0x7ffu) << 9u) | ((coordinates >> 21u) << 20u);
}

fn direction_in(word: u32) -> vec3f {
    return octahedral_decode((((word >> 9u) & 0x7ffu) << 5u) | (((word >> 20u) & 0x7ffu) << 21u) | 0x00100010u);
}

// Most that a photon counts for more where it comes in flat above its triangle, and less so above the curved surface.
const MOST_TILT = 8.0;

// What a photon counts for where the surface is shaded as if it faced elsewhere than its triangle does: as many arrive as the triangle
// catches, and irradiance is that of the other one (after Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997,
// section 5.3).
fn tilted(direction: vec3f, shaded: vec3f, geometric: vec3f) -> f32 {
    return clamp(dot(direction, shaded) / max(dot(direction, geometric), 1e-3), 0.0, MOST_TILT);
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
    let s = surface_at(hit);
    let material = s.triangle.w & TRIANGLE_MATERIAL;
    let is_back = has_transmission && !s.front && (materials[material].flags & MATERIAL_SOLID) != 0u;
    let media = path_words(PATH_MEDIA, slot);
    let began_inside = is_back && !media_hold(media, material);
    let kept = path_words(photon_settings.field, slot);
    let range = kept.x;
    // KHR_lights_punctual: a window that falls to zero at the range.
    let ratio = select(0.0, hit.t_max / bitcast<f32>(range), range != 0u);
    let window = saturate(1.0 - ratio * ratio * ratio * ratio);
    path_set_words(photon_settings.field, slot, vec4u(range, bitcast<u32>(window), select(kept.z, material + 1u, began_inside), 0u));
    let scattered = path_depth(slot);
    let is_inside = is_back || (has_transmission && medium_among(media) != 0u);
    if (scattered == 0u || is_inside || is_caster_throughout(material)) {
        return;
    }
    var carried = path_read(PATH_THROUGHPUT, slot);
    if (has_alpha && (s.triangle.w & TRIANGLE_ALPHA) != 0u) {
        // Of the photons that came here these are as many as the surface covers, and as many of the paths will ask for them.
        carried /= max(material_coverage(material, s.triangle, s.weights), LEAST_COVERAGE);
    }
    let rise = curved(s, material);
    if (dot(rise, rise) > 0.0) {
        carried *= stretch(hit, s);
    }
    path_set_words(photon_settings.field, slot, vec4u(bitcast<vec3u>(carried.xyz), with_direction(PHOTON_WAITS | scattered, s.wo)));
    path_set_words(photon_settings.field + 1u, slot, vec4u(bitcast<vec3u>(s.position + rise), octahedral_encode(s.geometric_normal)));
}

// Keeps a photon that waits at a place; those for which there is no room are lost.
fn keep_photon(slot: u32, flux: vec3f, scattered: u32, place: vec4u) {
    let at = atomicAdd(&photons_arrived[0], 1u);
    if (at >= photon_settings.photons) {
        return;
    }
    let number = hash2(hash2(frame.first_sample * frame.padded_pixels + frame.first_pixel + slot, scattered), photon_settings.seed);
    let words = array<u32, 8>(place.x, place.y, place.z, place.w,
        whole_flux(flux.x, number), whole_flux(flux.y, number + 1u), whole_flux(flux.z, number + 2u), scattered);
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
    path_set_words(PATH_UNSENT, slot, vec4u(0u));
    let kind = left.w & LEFT_KIND;
    let kept = path_words(photon_settings.field, slot);
    let waits = (kept.w & PHOTON_WAITS) != 0u;
    if (waits && kind != LEFT_CASTER) {
        var place = path_words(photon_settings.field + 1u, slot);
        var weight = 1.0;
        if (kind == LEFT_DIFFUSE) {
            weight = tilted(direction_in(kept.w), octahedral_decode(path_words(PATH_DIFFUSE, slot).w), octahedral_decode(place.w));
            // The very place that a path would ask from.
            place = vec4u(path_words(PATH_PLACE, slot).xyz, place.w);
        }
        // One that has neither been scattered nor passed is seen from behind the shading normal.
        if (kind != LEFT_NONE || rays[own_ray(slot)].t_min > 0.0) {
            keep_photon(slot, weight * bitcast<vec3f>(kept.xyz), kept.w & PHOTON_SCATTERED, place);
        }
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
