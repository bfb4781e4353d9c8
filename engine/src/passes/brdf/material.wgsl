// The material at a vertex: its BSDF and the frame that this is in.
//!include shared/thin_film.wgsl

// The tangent that anisotropic reflections follow: that of the surface, turned by the material and its texture.
fn stretched_tangent(s: Surface, material: u32, instance: u32, normal: vec3f, angle: f32, map: vec4f) -> vec3f {
    if (!has_layers) {
        return any_perpendicular(normal);
    }
    let along = surface_tangent(s, instance, normal);
    // The bitangent is of the surface, from whichever side it is seen.
    let across = cross(select(-normal, normal, s.front), along.xyz) * along.w;
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
              cosine: f32, coat_normal: vec3f, layers: array<vec4f, LAYER_TEXTURES>) {
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
            if (!(thickness > 0.0) || materials[material].iridescence_ior <= 1.0) {
                (*b).iridescence = 0.0; // nothing, or air, is no film
            }
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

struct MaterialSample {
    bsdf: Bsdf,
    frame: ShadingFrame,
    throughput: vec3f, // of the path, which may have one hue from here on
}

fn material_at(v: Vertex, throughput: vec3f, base_color: vec3f, normal: vec3f, texels: array<vec4f, 6>) -> MaterialSample {
    let metallic = metallic_at(v.slot, v.driven, v.material, texels[TEXTURE_METALLIC_ROUGHNESS]);
    let roughness = roughness_at(v.slot, v.driven, v.material, texels[TEXTURE_METALLIC_ROUGHNESS]);
    let specular = scalar_or(v.slot, v.driven, OUTPUT_SPECULAR,
        materials[v.material].specular * texels[TEXTURE_SPECULAR].w);
    let specular_color = color_or(v.slot, v.driven, OUTPUT_SPECULAR_COLOR,
        materials[v.material].specular_color * texels[TEXTURE_SPECULAR_COLOR].xyz);
    var f0 = materials[v.material].dielectric_f0;
    let ior = max(scalar_or(v.slot, v.driven, OUTPUT_IOR, materials[v.material].ior), 0.0);
    if (gives(v.slot, v.driven, OUTPUT_IOR)) {
        let ratio = (ior - 1.0) / (ior + 1.0);
        f0 = ratio * ratio;
    }
    var border = MediumBorder(select(1.0, 0.0, v.is_clear), f0, 1.0, throughput);
    if (v.is_solid) {
        border = medium_border(v, ior, throughput);
    }
    let dielectric_f0 = min(border.f0 * specular_color, vec3f(1.0));
    var b = plain_bsdf(base_color, metallic, roughness, dielectric_f0, specular * border.matched);

    var tangent = any_perpendicular(normal);
    if (has_layers || has_transmission) {
        let layers = layer_textures(v.material, v.surface.triangle, v.surface.weights);
        let turn = scalar_or(v.slot, v.driven, OUTPUT_ANISOTROPY_ROTATION, materials[v.material].anisotropy_rotation);
        tangent = stretched_tangent(v.surface, v.material, v.instance, normal, turn, layers[LAYER_ANISOTROPY]);
        let coat_normal = mapped_normal(v.surface, v.material, v.instance, FIRST_LAYER_TEXTURE + LAYER_COAT_NORMAL,
            layers[LAYER_COAT_NORMAL].xyz, materials[v.material].coat_normal_scale);
        let local = to_local(ShadingFrame(tangent, cross(normal, tangent), normal), coat_normal);
        add_layers(&b, v.slot, v.driven, v.material, roughness, border.eta, v.is_inside, dot(normal, v.surface.wo), local,
            layers);
        if (border.matched == 0.0 && metallic <= 0.0) {
            // However rough it is, a border between equals turns nothing aside.
            b.alpha = vec2f(MIN_ALPHA);
        }
    }
    return MaterialSample(b, ShadingFrame(tangent, cross(normal, tangent), normal), border.throughput);
}
