// One vertex of a path: gathers emission, samples a light and the BSDF, and sends the path on. Light and BSDF samples are
// combined by multiple importance sampling. `entry.wgsl` is the pass; each step of it has a function in the files beside
// this one.
//!include brdf/vertex.wgsl
//!include brdf/emission.wgsl
//!include brdf/media.wgsl
//!include brdf/material.wgsl
//!include brdf/scattering.wgsl

fn shade_vertex(slot: u32) {
    var p = path_state(slot);
    let hit = rays[own_ray(slot)];
    if (waits_for_program(slot)) {
        follow_shadow_ray(slot, hit);
        return;
    }
    p.radiance = with_light_sample(p);
    let receiver_before = path_words(PATH_LIGHT, slot).w; // of the vertex that the ray comes from
    path_set_words(PATH_LIGHT, slot, vec4u(0u, 0u, 0u, receiver_before));

    let cone_width = p.cone_width + frame.pixel_spread * min(hit.t_max, 1e10);
    if (hit.triangle == MISS) {
        p.radiance = handle_escaped_ray(p, hit, receiver_before);
        path_write(PATH_RADIANCE, slot, vec4f(p.radiance, cone_width));
        return;
    }

    let v = vertex_at(p, hit);
    let passage = sample_passage(v, hit, p.throughput);
    if (passage.passes) {
        pass_on(p, passage, hit.t_max);
        return;
    }
    p.throughput = passage.throughput;

    let is_unlit = (v.flags & MATERIAL_UNLIT) != 0u;
    let wanted = select(0xffffffffu, 1u << TEXTURE_EMISSION, p.is_last && !is_unlit);
    let texels = material_textures(v.material, wanted, v.surface.triangle, v.surface.weights);
    let base_color = base_color_at(slot, v.driven, v.material, v.surface, texels[TEXTURE_BASE_COLOR]);
    if (is_unlit) {
        // A texture may give less than nothing, which isn't light.
        let found = limited(p.throughput * max(base_color, vec3f(0.0)), f32(p.depth));
        leave_unsent(p, v, found);
        if (splits_light) {
            note_found(p, PATH_FOUND, found, true, light_group(materials[v.own_material].flags));
        }
        p.radiance += found;
        path_write(PATH_RADIANCE, slot, vec4f(p.radiance, cone_width));
        return;
    }
    p.radiance = handle_emissive_intersection(p, v, hit, receiver_before, texels[TEXTURE_EMISSION]);
    path_write(PATH_RADIANCE, slot, vec4f(p.radiance, cone_width));
    if (p.is_last) {
        return;
    }

    let normal = shading_normal_at(slot, v.driven, v.material, v.surface, v.instance, texels[TEXTURE_NORMAL]);
    let m = material_at(v, p.throughput, base_color, normal, texels);
    p.throughput = m.throughput;
    let wo = to_local(m.frame, v.surface.wo);
    if (wo.z <= 0.0) {
        // Seen from behind the shading normal: nothing is reflected.
        return;
    }
    var l = lobes(m.bsdf, wo);
    if (leaves_diffuse && (frame.caches & CACHE_GIVES) != 0u) {
        l = favouring_reflection(m.bsdf, l);
    }
    let origins = ray_origins(v, m.bsdf);
    let receiver = receiver_at(v, m, origins);
    let shares = light_shares(origins.above, receiver, v.id);
    var going_on = 1.0;
    if (leaves_diffuse) {
        going_on = leave_scattering(p, v, m, l, origins, shares.rays);
    }
    let has_shadow_ray = sample_direct_light(p, v, m, l, wo, origins, receiver, shares, going_on);
    if (!sample_indirect(p, v, m, l, wo, origins, going_on) && has_program_shadows && has_shadow_ray) {
        wait_for_shadow_ray(p);
    }
}
