// Records what the first surface of each path gives to the layers of the film: that from which the path was scattered
// first, or on which it ended. Rounds overwrite each other as long as nothing has scattered the path, so that surfaces
// which it passes (holes, clear walls, borders inside bodies) count no more than for the picture. One thread per path that
// is under way, before the surface is shaded.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include shared/appearance.wgsl
//!include film_layers/samples.wgsl
//!include generated/film_layers.wgsl

// The surface, with what its texture program said.
struct FirstSurface {
    slot: u32,
    instance: u32,
    surface: Surface,
    material: u32, // after blends
    driven: u32, // outputs that the program gave
}

fn first_normal(at: FirstSurface) -> vec3f {
    let texels = material_textures(at.material, 1u << TEXTURE_NORMAL, at.surface.triangle, at.surface.weights);
    return shading_normal_at(at.slot, at.driven, at.material, at.surface, at.instance, texels[TEXTURE_NORMAL]);
}

fn first_base_color(at: FirstSurface) -> vec3f {
    let texels = material_textures(at.material, 1u << TEXTURE_BASE_COLOR, at.surface.triangle, at.surface.weights);
    return base_color_at(at.slot, at.driven, at.material, at.surface, texels[TEXTURE_BASE_COLOR]);
}

// Surfaces without shading emit their colour.
fn first_emission(at: FirstSurface) -> vec3f {
    let flags = materials[at.material].flags;
    if ((flags & MATERIAL_UNLIT) != 0u) {
        return first_base_color(at);
    }
    if (!at.surface.front && (flags & MATERIAL_DOUBLE_SIDED) == 0u) {
        return vec3f(0.0);
    }
    let texels = material_textures(at.material, 1u << TEXTURE_EMISSION, at.surface.triangle, at.surface.weights);
    return emission_at(at.slot, at.driven, at.material, texels[TEXTURE_EMISSION]);
}

// glTF counts v from the upper edge of a picture.
fn first_uv(at: FirstSurface) -> vec2f {
    let uv = interpolate_uv(at.surface.triangle, at.surface.weights, 0u);
    return vec2f(uv.x, 1.0 - uv.y);
}

@compute @workgroup_size(64)
fn record_layers(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                 @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    if (path_depth(slot) != 0u) {
        return;
    }
    let hit = rays[own_ray(slot)];
    if (hit.triangle == MISS) {
        layer_sample_set(0u, slot, 0.0);
        return;
    }
    layer_sample_set(0u, slot, 1.0);
    let surface = surface_at(hit);
    let own_material = surface.triangle.w & TRIANGLE_MATERIAL;
    var at = FirstSurface(slot, hit.instance, surface, own_material, 0u);
    if (runs_program(materials[own_material].flags, 0u)) {
        let resolved = path_words(PATH_STATE, slot);
        at.material = resolved.x;
        at.driven = resolved.y;
    }
    record_each(at);
}
