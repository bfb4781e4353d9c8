// One vertex of every active path: gathers emission, samples a light and the BSDF, and sends the path on.
// Light and BSDF samples are combined by multiple importance sampling.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/queues.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/surface.wgsl
//!include shared/bsdf.wgsl
//!include shared/environment.wgsl
//!include shared/lights.wgsl

// Bits of PATH_PROC_MATERIAL's second word; the order of `programs.wgsl`'s outputs.
const DRIVEN_BASE_COLOR = 1u;
const DRIVEN_METALLIC = 2u;
const DRIVEN_ROUGHNESS = 4u;
const DRIVEN_EMISSION = 8u;

const ROULETTE_START = 4u;

// Normal map in the frame of the interpolated normal; `s.shading_normal` where there is none.
fn mapped_normal(s: Surface, material: u32, instance: u32, map: vec3f) -> vec3f {
    if ((materials[material].texture_mask & (1u << TEXTURE_NORMAL)) == 0u) {
        return s.shading_normal;
    }
    let texel = map * 2.0 - 1.0;
    let scale = materials[material].normal_scale;
    // The map is made for the front: undo the flip, perturb, flip again.
    let normal = select(-s.shading_normal, s.shading_normal, s.front);
    let tangent = surface_tangent(s, instance, normal);
    let bitangent = cross(normal, tangent.xyz) * tangent.w;
    let mapped = tangent.xyz * (texel.x * scale) + bitangent * (texel.y * scale) + normal * texel.z;
    let length2 = dot(mapped, mapped);
    if (length2 < 1e-12) {
        return s.shading_normal;
    }
    return select(-mapped, mapped, s.front) * inverseSqrt(length2);
}

@compute @workgroup_size(64)
fn brdf(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
        @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let bounce = bounce_number();
    let path = path_id(slot);
    let hit = rays[slot];
    let before = path_read(PATH_THROUGHPUT, slot);
    let throughput = before.xyz;
    let bsdf_pdf = before.w; // 0 for camera rays
    let gathered = path_read(PATH_RADIANCE, slot);
    var radiance = gathered.xyz;
    let cone_width = gathered.w + frame.pixel_spread * min(hit.t_max, 1e10);

    // The light sample of the previous vertex.
    if (rays[frame.capacity + slot].triangle == MISS) {
        radiance += path_read(PATH_LIGHT, slot).xyz;
    }
    path_write(PATH_LIGHT, slot, vec4f(0.0));

    if (hit.triangle == MISS) {
        var weight = 1.0;
        if (has_environment && bsdf_pdf > 0.0) {
            weight = mis_weight(bsdf_pdf, frame.environment_probability * environment_pdf(hit.direction));
        }
        radiance += throughput * environment_radiance(hit.direction) * weight;
        path_write(PATH_RADIANCE, slot, vec4f(radiance, cone_width));
        return;
    }

    let s = surface_at(hit);
    let own_material = s.triangle.w & TRIANGLE_MATERIAL;
    var material = own_material;
    var driven = 0u;
    if (runs_program(materials[own_material].flags, bounce)) {
        let resolved = paths[PATH_PROC_MATERIAL * frame.capacity + slot];
        material = resolved.x;
        driven = resolved.y;
    }
    let flags = materials[material].flags;

    var base_color: vec3f;
    var proc_base = vec4f(0.0);
    if ((driven & (DRIVEN_BASE_COLOR | DRIVEN_METALLIC)) != 0u) {
        proc_base = path_read(PATH_PROC_BASE, slot);
    }
    var proc_emission = vec4f(0.0);
    if ((driven & (DRIVEN_EMISSION | DRIVEN_ROUGHNESS)) != 0u) {
        proc_emission = path_read(PATH_PROC_EMISSION, slot);
    }
    // After the last scattering only emission matters.
    let wanted = select(0xffffffffu, 1u << TEXTURE_EMISSION, bounce >= frame.max_depth && (flags & MATERIAL_UNLIT) == 0u);
    let texels = material_textures(material, wanted, s.triangle, s.weights);
    if ((driven & DRIVEN_BASE_COLOR) != 0u) {
        base_color = proc_base.xyz;
    } else {
        base_color = materials[material].base_color.xyz * texels[TEXTURE_BASE_COLOR].xyz
            * interpolate_color(s.triangle, s.weights).xyz;
    }
    if ((flags & MATERIAL_UNLIT) != 0u) {
        path_write(PATH_RADIANCE, slot, vec4f(radiance + throughput * base_color, cone_width));
        return;
    }

    if (s.front || (flags & MATERIAL_DOUBLE_SIDED) != 0u) {
        var emission = materials[material].emission;
        if ((driven & DRIVEN_EMISSION) != 0u) {
            emission = max(proc_emission.xyz, vec3f(0.0));
        } else if (max_component(emission) > 0.0) {
            emission *= texels[TEXTURE_EMISSION].xyz;
        }
        var weight = 1.0;
        let light_pdf = materials[own_material].light_pdf * (1.0 - frame.environment_probability);
        if (bsdf_pdf > 0.0 && light_pdf > 0.0) {
            let cosine = max(dot(s.geometric_normal, s.wo), 1e-7);
            weight = mis_weight(bsdf_pdf, light_pdf * hit.t_max * hit.t_max / cosine);
        }
        radiance += throughput * emission * weight;
    }
    path_write(PATH_RADIANCE, slot, vec4f(radiance, cone_width));
    if (bounce >= frame.max_depth) {
        return;
    }

    let normal = mapped_normal(s, material, hit.instance, texels[TEXTURE_NORMAL].xyz);
    let tangent = any_perpendicular(normal);
    let bitangent = cross(normal, tangent);
    let wo = vec3f(dot(s.wo, tangent), dot(s.wo, bitangent), dot(s.wo, normal));
    if (wo.z <= 0.0) {
        // Seen from behind the shading normal: nothing is reflected.
        return;
    }

    let metallic_roughness = texels[TEXTURE_METALLIC_ROUGHNESS];
    var metallic = materials[material].metallic * metallic_roughness.z;
    if ((driven & DRIVEN_METALLIC) != 0u) {
        metallic = proc_base.w;
    }
    var roughness = materials[material].roughness * metallic_roughness.y;
    if ((driven & DRIVEN_ROUGHNESS) != 0u) {
        roughness = proc_emission.w;
    }
    let specular = materials[material].specular * texels[TEXTURE_SPECULAR].w;
    let specular_color = materials[material].specular_color * texels[TEXTURE_SPECULAR_COLOR].xyz;
    let dielectric_f0 = min(materials[material].dielectric_f0 * specular_color, vec3f(1.0));
    let b = make_bsdf(base_color, metallic, roughness, dielectric_f0, specular);

    // Next-event estimation.
    if (frame.light_count > 0u || frame.environment_probability > 0.0) {
        let choice = random2(path, bounce_dimension(bounce, DIMENSION_LIGHT_CHOICE)).x;
        let point = random2(path, bounce_dimension(bounce, DIMENSION_LIGHT_POINT));
        let light = light_sample(s.position, choice, point);
        let wi = vec3f(dot(light.wi, tangent), dot(light.wi, bitangent), dot(light.wi, normal));
        if (light.pdf > 0.0 && wi.z > 0.0 && dot(light.wi, s.geometric_normal) > 0.0) {
            let value = bsdf_eval(b, wo, wi);
            let weight = select(mis_weight(light.pdf, value.w), 1.0, light.delta);
            let contribution = throughput * value.xyz * light.radiance * (weight / light.pdf);
            if (max_component(contribution) > 0.0) {
                let origin = offset_origin(s.position, s.geometric_normal);
                var direction = light.wi;
                var t_max = light.distance;
                if (light.distance < FAR) {
                    let to = s.position + light.wi * light.distance - origin;
                    t_max = length(to);
                    direction = to / t_max;
                    t_max *= 0.9999; // stops short of the light's own surface
                }
                rays[frame.capacity + slot] = RayHit(origin, 0.0, direction, t_max, vec2f(0.0), MISS, 0u);
                path_write(PATH_LIGHT, slot, vec4f(contribution, 0.0));
                queue_append(QUEUE_SHADOW, slot);
            }
        }
    }

    // The next direction.
    let lobe = random2(path, bounce_dimension(bounce, DIMENSION_BSDF_LOBE));
    let sampled = bsdf_sample(b, wo, random2(path, bounce_dimension(bounce, DIMENSION_BSDF_DIRECTION)), lobe.x);
    let direction = tangent * sampled.wi.x + bitangent * sampled.wi.y + normal * sampled.wi.z;
    if (sampled.pdf <= 0.0 || dot(direction, s.geometric_normal) <= 0.0) {
        return;
    }
    var next = throughput * sampled.weight;
    if (bounce >= ROULETTE_START) {
        let survival = clamp(max_component(next), 0.05, 0.95);
        if (lobe.y >= survival) {
            return;
        }
        next /= survival;
    }
    if (max_component(next) <= 0.0) {
        return;
    }
    path_write(PATH_THROUGHPUT, slot, vec4f(next, sampled.pdf));
    rays[slot] = RayHit(offset_origin(s.position, s.geometric_normal), 0.0, normalize(direction), 1e30, vec2f(0.0), MISS, 0u);
    queue_append(QUEUE_ACTIVE, slot);
}
