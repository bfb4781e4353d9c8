// One vertex of a path: gathers emission, samples a light and the BSDF, and sends the path on. Light and BSDF samples are
// combined by multiple importance sampling. `entry.wgsl` is the pass.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/outputs.wgsl
//!include shared/queues.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/media.wgsl
//!include shared/surface.wgsl
//!include shared/appearance.wgsl
//!include shared/bsdf.wgsl
//!include shared/thin_film.wgsl
//!include shared/environment.wgsl
//!include shared/lights.wgsl
//!include shared/estimator.wgsl

// The tangent that anisotropic reflections follow: that of the surface, turned by the material and its texture.
fn stretched_tangent(s: Surface, material: u32, instance: u32, normal: vec3f, angle: f32, map: vec4f) -> vec3f {
    if (!has_layers) {
        return any_perpendicular(normal);
    }
    let along = surface_tangent(s, instance, normal);
    let across = cross(normal, along.xyz) * along.w;
    var direction = unit_circle(angle / (2.0 * PI));
    if ((materials[material].texture_mask & (1u << (FIRST_LAYER_TEXTURE + LAYER_ANISOTROPY))) != 0u) {
        let texel = map.xy * 2.0 - 1.0;
        direction = vec2f(direction.x * texel.x - direction.y * texel.y, direction.y * texel.x + direction.x * texel.y);
    }
    let stretched = along.xyz * direction.x + across * direction.y;
    if (!is_direction(stretched)) {
        return along.xyz;
    }
    return normalize(stretched);
}

// The layers above and the inside below a metallic-roughness surface.
fn add_layers(b: ptr<function, Bsdf>, slot: u32, driven: u32, material: u32, roughness: f32, eta: f32, is_inside: bool,
              cosine: f32, coat_normal: vec3f, layers: array<vec4f, 11>) {
    if (has_layers && !is_inside) {
        (*b).coat = saturate(scalar_or(slot, driven, OUTPUT_COAT, materials[material].coat * layers[LAYER_COAT].x));
        let coat_roughness = saturate(scalar_or(slot, driven, OUTPUT_COAT_ROUGHNESS,
            materials[material].coat_roughness * layers[LAYER_COAT_ROUGHNESS].y));
        (*b).coat_alpha = max(coat_roughness * coat_roughness, MIN_ALPHA);
        (*b).coat_normal = coat_normal;
        (*b).sheen_color = min(color_or(slot, driven, OUTPUT_SHEEN_COLOR,
            materials[material].sheen_color * layers[LAYER_SHEEN_COLOR].xyz), vec3f(1.0));
        (*b).sheen_roughness = saturate(scalar_or(slot, driven, OUTPUT_SHEEN_ROUGHNESS,
            materials[material].sheen_roughness * layers[LAYER_SHEEN_ROUGHNESS].w));
        (*b).iridescence = saturate(scalar_or(slot, driven, OUTPUT_IRIDESCENCE,
            materials[material].iridescence * layers[LAYER_IRIDESCENCE].x));
        if ((*b).iridescence > 0.0) {
            let range = materials[material].iridescence_thickness;
            let thickness = max(scalar_or(slot, driven, OUTPUT_IRIDESCENCE_THICKNESS,
                mix(range.x, range.y, layers[LAYER_IRIDESCENCE_THICKNESS].y)), 0.0);
            let f0 = mix((*b).specular * (*b).dielectric_f0, (*b).base_color, (*b).metallic);
            (*b).iridescent_f0 = film_reflection(saturate(cosine), materials[material].iridescence_ior, thickness, f0);
        }
    }
    if (has_layers) {
        let strength = scalar_or(slot, driven, OUTPUT_ANISOTROPY,
            materials[material].anisotropy * layers[LAYER_ANISOTROPY].z);
        (*b).alpha = anisotropic_alpha(roughness, saturate(strength));
    }
    if (has_transmission) {
        (*b).transmission = saturate(scalar_or(slot, driven, OUTPUT_TRANSMISSION,
            materials[material].transmission * layers[LAYER_TRANSMISSION].x));
        (*b).diffuse_transmission = saturate(scalar_or(slot, driven, OUTPUT_DIFFUSE_TRANSMISSION,
            materials[material].diffuse_transmission * layers[LAYER_DIFFUSE_TRANSMISSION].w));
        (*b).diffuse_transmission_color = saturate(color_or(slot, driven, OUTPUT_DIFFUSE_TRANSMISSION_COLOR,
            materials[material].diffuse_transmission_color * layers[LAYER_DIFFUSE_TRANSMISSION_COLOR].xyz));
        (*b).eta = eta;
    }
}

// How far above its triangle a point lies on the curved surface that the vertices' normals suggest: rays that leave from
// there aren't stopped by the coarseness of the mesh (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021,
// chapter 4). Zero where the surface is flat or hollow.
fn curved_lift(s: Surface, instance: u32) -> vec3f {
    if (s.is_flat) {
        return vec3f(0.0);
    }
    let object_from_world = instances[instance].object_from_world;
    let p = transform_point(object_from_world, s.position);
    let side = select(-1.0, 1.0, s.front);
    var lift = vec3f(0.0);
    for (var i = 0u; i < 3u; i++) {
        let vertex = vertices[s.triangle[i]];
        let normal = octahedral_decode(vertex.w) * side;
        lift -= normal * (s.weights[i] * min(dot(p - bitcast<vec3f>(vertex.xyz), normal), 0.0));
    }
    return transform_vector(instances[instance].world_from_object, lift);
}

// Sends the path on behind the surface that it met, as if nothing were there.
fn pass_on(slot: u32, throughput: vec4f, radiance: vec4f, t: f32) {
    path_write(PATH_THROUGHPUT, slot, throughput);
    path_write(PATH_RADIANCE, slot, radiance);
    rays[own_ray(slot)].t_min = t;
    rays[own_ray(slot)].t_max = 1e30;
    rays[own_ray(slot)].triangle = MISS;
    queue_append(QUEUE_ACTIVE, slot);
}

// The index of refraction of a medium for the path's hue: 1 + material, 0 for air. `own` is the material at hand, whose
// index a texture program may have changed to `own_ior`.
fn medium_ior(medium: u32, own: u32, own_ior: f32, hue: f32) -> f32 {
    if (medium == 0u) {
        return 1.0;
    }
    let ior = select(materials[medium - 1u].ior, own_ior, medium == own + 1u);
    return dispersed(max(ior, 1.0), materials[medium - 1u].dispersion, hue);
}

fn medium_dispersion(medium: u32) -> f32 {
    if (medium == 0u) {
        return 0.0;
    }
    return materials[medium - 1u].dispersion;
}

// Whether a ray leaves the surface on the side of its shading normal that it was meant for; `side` is its cosine to the
// triangle. Above a curved surface it may dip below the triangle's plane: then it is for tracing to say what it meets.
fn leaves(cosine: f32, side: f32, is_lifted: bool) -> bool {
    if (cosine > 0.0) {
        return side > 0.0 || is_lifted;
    }
    return has_transmission && cosine < 0.0 && side < 0.0;
}

// A path that ends here, but whose shadow ray may have to wait for texture programs, goes on with a dead ray.
fn end_path(slot: u32, depth: u32, has_shadow_ray: bool) {
    if (has_program_shadows && has_shadow_ray) {
        path_set_words(PATH_STATE, slot, vec4u(0u, 0u, depth + 1u, 0u));
        rays[own_ray(slot)].t_max = DEAD;
        queue_append(QUEUE_ACTIVE, slot);
    }
}

fn shade_vertex(slot: u32) {
    let depth = path_depth(slot);
    let path = path_id(slot);
    let hit = rays[own_ray(slot)];
    let before = path_read(PATH_THROUGHPUT, slot);
    var throughput = before.xyz;
    let bsdf_pdf = before.w; // 0 for camera rays
    let gathered = path_read(PATH_RADIANCE, slot);
    var radiance = gathered.xyz;
    let cone_width = gathered.w + frame.pixel_spread * min(hit.t_max, 1e10);

    // The light sample of the previous vertex.
    let blocker = rays[shadow_ray(slot)].triangle;
    if (has_program_shadows && blocker != MISS && (triangles[blocker].w & TRIANGLE_PROGRAM_ALPHA) != 0u) {
        // The shadow ray met a surface that lets some of it pass: how much is part of PATH_LIGHT by now. It goes on
        // behind that surface, and the path waits for it.
        rays[shadow_ray(slot)].triangle = MISS;
        if (max_component(path_read(PATH_LIGHT, slot).xyz) > 0.0) {
            queue_append(QUEUE_SHADOW, slot);
        } else {
            path_set_words(PATH_LIGHT_POINT, slot, vec4u(MISS, 0u, 0u, 0u));
        }
        rays[own_ray(slot)].t_max = select(1e30, DEAD, hit.t_max < 0.0);
        rays[own_ray(slot)].triangle = MISS;
        queue_append(QUEUE_ACTIVE, slot);
        return;
    }
    if (blocker == MISS) {
        radiance += waiting_light(slot, depth);
    }
    let receiver_before = path_words(PATH_LIGHT, slot).w; // of the vertex that the ray comes from
    path_set_words(PATH_LIGHT, slot, vec4u(0u, 0u, 0u, receiver_before));

    if (hit.triangle == MISS) {
        if (has_program_shadows && hit.t_max < 0.0) {
            path_write(PATH_RADIANCE, slot, vec4f(radiance, cone_width));
            return;
        }
        var weight = 1.0;
        if (has_environment && bsdf_pdf > 0.0) {
            weight = met_light_weight(bsdf_pdf, frame.environment_probability * environment_pdf(hit.direction));
        }
        let sky = environment_radiance(hit.direction) * weight + disk_radiance(hit.direction, bsdf_pdf);
        radiance += limited(throughput * sky, f32(depth));
        path_write(PATH_RADIANCE, slot, vec4f(radiance, cone_width));
        return;
    }

    let s = surface_at(hit);
    let own_material = s.triangle.w & TRIANGLE_MATERIAL;
    var material = own_material;
    var driven = 0u; // the outputs that the texture program gave
    if (runs_program(materials[own_material].flags, depth)) {
        let resolved = path_words(PATH_STATE, slot);
        material = resolved.x;
        driven = resolved.y;
    }
    let flags = materials[material].flags;
    let is_solid = has_transmission && (flags & MATERIAL_SOLID) != 0u;
    // Seen from the inside of a transparent body.
    let is_inside = is_solid && !s.front;

    // The bodies that the ray went through; where the path began inside one, its back says so.
    var media = vec4u(0u);
    var medium = 0u;
    if (has_transmission) {
        media = path_words(PATH_MEDIA, slot);
        if (is_inside && !media_hold(media, own_material)) {
            media = media_entered(media, own_material);
        }
        medium = medium_among(media);
        throughput *= medium_transmittance(medium, hit.t_max - hit.t_min);
    }

    if (gives(driven, OUTPUT_OPACITY)) {
        let coin = random_at(path, vertex_dimension(depth, DIMENSION_OPACITY), triangle_number(s.triangle),
            instances[hit.instance].source);
        if (coin >= scalar_or(slot, driven, OUTPUT_OPACITY, 1.0)) {
            pass_on(slot, vec4f(throughput, bsdf_pdf), vec4f(radiance, gathered.w), hit.t_max);
            return;
        }
    }

    // What is behind the surface of a body. Inside one that counts more, nothing changes here.
    var beyond = media;
    if (is_solid) {
        beyond = media_behind(is_inside, media, own_material);
        if (medium_among(beyond) == medium) {
            path_set_words(PATH_MEDIA, slot, beyond);
            pass_on(slot, vec4f(throughput, bsdf_pdf), vec4f(radiance, gathered.w), hit.t_max);
            return;
        }
    }

    // A thin clear wall: what goes straight through meets the lights as if the wall were only a filter, as shadow rays do.
    let is_clear = has_clear && (materials[own_material].flags & MATERIAL_CLEAR) != 0u;
    if (is_clear) {
        let passing = clear_transmittance(material, s.triangle, s.weights, dot(s.geometric_normal, s.wo));
        let chance = max_component(passing);
        let coin = random_at(path, vertex_dimension(depth, DIMENSION_OPACITY), triangle_number(s.triangle),
            instances[hit.instance].source);
        if (coin < chance) {
            pass_on(slot, vec4f(throughput * passing / chance, bsdf_pdf), vec4f(radiance, gathered.w), hit.t_max);
            return;
        }
        throughput /= 1.0 - chance;
    }

    // After the last scattering only emission matters.
    let wanted = select(0xffffffffu, 1u << TEXTURE_EMISSION, depth >= frame.max_depth && (flags & MATERIAL_UNLIT) == 0u);
    let texels = material_textures(material, wanted, s.triangle, s.weights);
    let base_color = base_color_at(slot, driven, material, s, texels[TEXTURE_BASE_COLOR]);
    if ((flags & MATERIAL_UNLIT) != 0u) {
        path_write(PATH_RADIANCE, slot, vec4f(radiance + limited(throughput * base_color, f32(depth)), cone_width));
        return;
    }

    if (s.front || (flags & MATERIAL_DOUBLE_SIDED) != 0u) {
        let emission = emission_at(slot, driven, material, texels[TEXTURE_EMISSION]);
        var weight = 1.0;
        if (bsdf_pdf > 0.0 && materials[own_material].light_radiance > 0.0 && max_component(emission) > 0.0) {
            let cosine = max(dot(s.geometric_normal, s.wo), 1e-7);
            weight = met_light_weight(bsdf_pdf, light_hit_pdf(hit, receiver_before, cosine));
        }
        radiance += limited(throughput * emission * weight, f32(depth));
    }
    path_write(PATH_RADIANCE, slot, vec4f(radiance, cone_width));
    if (depth >= frame.max_depth) {
        return;
    }

    let normal = shading_normal_at(slot, driven, material, s, hit.instance, texels[TEXTURE_NORMAL]);
    let metallic = metallic_at(slot, driven, material, texels[TEXTURE_METALLIC_ROUGHNESS]);
    let roughness = roughness_at(slot, driven, material, texels[TEXTURE_METALLIC_ROUGHNESS]);
    let specular = scalar_or(slot, driven, OUTPUT_SPECULAR, materials[material].specular * texels[TEXTURE_SPECULAR].w);
    let specular_color = color_or(slot, driven, OUTPUT_SPECULAR_COLOR,
        materials[material].specular_color * texels[TEXTURE_SPECULAR_COLOR].xyz);
    var f0 = materials[material].dielectric_f0;
    let ior = max(scalar_or(slot, driven, OUTPUT_IOR, materials[material].ior), 0.0);
    if (gives(driven, OUTPUT_IOR)) {
        let ratio = (ior - 1.0) / (ior + 1.0);
        f0 = ratio * ratio;
    }
    var matched = 1.0;
    var eta = select(1.0, 0.0, is_clear);
    if (is_solid) {
        // The border of two media.
        let behind = medium_among(beyond);
        var state = path_words(PATH_STATE, slot);
        var hue = bitcast<f32>(state.w);
        if (hue == 0.0 && max(medium_dispersion(medium), medium_dispersion(behind)) > 0.0) {
            // From here on the path has one hue. It is kept off zero, which stands for white.
            hue = hue_of(random2(path, vertex_dimension(depth, DIMENSION_HUE))) + HUE_OFFSET;
            throughput *= hue_weight(hue - HUE_OFFSET);
            path_set_words(PATH_STATE, slot, vec4u(state.xyz, bitcast<u32>(hue)));
        }
        let pure = select(hue - HUE_OFFSET, 0.5, hue == 0.0);
        let here = medium_ior(medium, own_material, ior, pure);
        let there = medium_ior(behind, own_material, ior, pure);
        eta = there / here;
        let ratio = (there - here) / (there + here);
        f0 = ratio * ratio;
        if (abs(ratio) < 1e-4) {
            // Nothing is reflected between equals.
            eta = 1.0;
            matched = 0.0;
        }
    }
    let dielectric_f0 = min(f0 * specular_color, vec3f(1.0));
    var b = plain_bsdf(base_color, metallic, roughness, dielectric_f0, specular * matched);

    // The frame of the BSDF; its x is where anisotropic reflections are stretched to.
    var tangent = any_perpendicular(normal);
    if (has_layers || has_transmission) {
        let layers = layer_textures(material, s.triangle, s.weights);
        let turn = scalar_or(slot, driven, OUTPUT_ANISOTROPY_ROTATION, materials[material].anisotropy_rotation);
        tangent = stretched_tangent(s, material, hit.instance, normal, turn, layers[LAYER_ANISOTROPY]);
        let coat_normal = mapped_normal(s, material, hit.instance, FIRST_LAYER_TEXTURE + LAYER_COAT_NORMAL,
            layers[LAYER_COAT_NORMAL].xyz, materials[material].coat_normal_scale);
        let local = vec3f(dot(coat_normal, tangent), dot(coat_normal, cross(normal, tangent)), dot(coat_normal, normal));
        add_layers(&b, slot, driven, material, roughness, eta, is_inside, dot(normal, s.wo), local, layers);
    }
    let bitangent = cross(normal, tangent);
    let wo = vec3f(dot(s.wo, tangent), dot(s.wo, bitangent), dot(s.wo, normal));
    if (wo.z <= 0.0) {
        // Seen from behind the shading normal: nothing is reflected.
        return;
    }

    let l = lobes(b, wo);

    // Where rays leave that are reflected. Where others go through, all leave the triangle itself, so that lights are
    // weighed from one point.
    let is_opaque = !has_transmission || (b.transmission <= 0.0 && b.diffuse_transmission <= 0.0);
    let lift = select(vec3f(0.0), curved_lift(s, hit.instance), is_opaque);
    let is_lifted = dot(lift, lift) > 1e-12 * dot(s.position, s.position);
    let below = offset_origin(s.position, -s.geometric_normal);
    let above = offset_origin(s.position + lift, s.geometric_normal);

    // Next-event estimation.
    var has_shadow_ray = false;
    // Where a ray may dip below the triangle's plane, the shading normal's horizon is what counts.
    let facing = octahedral_encode(select(s.geometric_normal, normal, is_lifted));
    let receiver = select(RECEIVER_ALL_AROUND, facing, is_opaque);
    path_set_words(PATH_LIGHT, slot, vec4u(0u, 0u, 0u, receiver));
    if (light_groups() > 0u) {
        let numbers = random4(path, vertex_dimension(depth, DIMENSION_LIGHT), GROUP_LIGHT);
        let light = light_sample(s.position + lift, above, receiver, numbers.z, numbers.xy);
        let wi = vec3f(dot(light.wi, tangent), dot(light.wi, bitangent), dot(light.wi, normal));
        if (light.pdf > 0.0 && leaves(wi.z, dot(light.wi, s.geometric_normal), is_lifted)) {
            let value = bsdf_eval(b, l, wo, wi);
            let weight = light_sample_weight(light.pdf, value.w, light.delta);
            var contribution = throughput * value.xyz * light.radiance * (weight / light.pdf);
            if (has_transmission && light.distance < FAR) {
                let through = medium_among(select(media, beyond, wi.z < 0.0));
                contribution *= medium_transmittance(through, light.distance);
            }
            if (max_component(contribution) > 0.0) {
                let origin = select(below, above, wi.z > 0.0);
                var direction = light.wi;
                var t_max = light.distance;
                if (light.distance < FAR) {
                    let to = s.position + lift + light.wi * light.distance - origin;
                    t_max = length(to);
                    direction = to / t_max;
                    t_max *= 0.9999; // stops short of the light's own surface
                }
                rays[shadow_ray(slot)] = RayHit(origin, 0.0, direction, t_max, vec2f(0.0), MISS, 0u);
                path_set_words(PATH_LIGHT, slot, vec4u(bitcast<vec3u>(contribution), receiver));
                if (has_program_shadows) {
                    path_set_words(PATH_LIGHT_POINT, slot, light.point);
                }
                queue_append(QUEUE_SHADOW, slot);
                has_shadow_ray = true;
            }
        }
    }

    // The next direction.
    let numbers = random4(path, vertex_dimension(depth, DIMENSION_BSDF), GROUP_BSDF);
    let sampled = bsdf_sample(b, l, wo, numbers.xy, numbers.z);
    let direction = tangent * sampled.wi.x + bitangent * sampled.wi.y + normal * sampled.wi.z;
    if (sampled.pdf <= 0.0 || !leaves(sampled.wi.z, dot(direction, s.geometric_normal), is_lifted)) {
        end_path(slot, depth, has_shadow_ray);
        return;
    }
    var density = 1.0;
    if (has_transmission) {
        let next_media = select(media, beyond, sampled.wi.z < 0.0);
        path_set_words(PATH_MEDIA, slot, next_media);
        let next_medium = medium_among(next_media);
        if (next_medium != 0u) {
            density = materials[next_medium - 1u].ior;
        }
    }
    var next = throughput * sampled.weight;
    if (depth >= frame.roulette_start) {
        // Inside a body radiance is denser, and throughput lower, by the square of its index; that is no reason to end.
        let survival = clamp(max_component(next) * density * density, 0.05, 0.95);
        if (numbers.w >= survival) {
            end_path(slot, depth, has_shadow_ray);
            return;
        }
        next /= survival;
    }
    if (max_component(next) <= 0.0) {
        end_path(slot, depth, has_shadow_ray);
        return;
    }
    path_write(PATH_THROUGHPUT, slot, vec4f(next, sampled.pdf));
    path_set_words(PATH_STATE, slot, vec4u(0u, 0u, depth + 1u, path_words(PATH_STATE, slot).w));
    rays[own_ray(slot)] = RayHit(select(below, above, sampled.wi.z > 0.0), 0.0, normalize(direction), 1e30, vec2f(0.0), MISS, 0u);
    queue_append(QUEUE_ACTIVE, slot);
}
