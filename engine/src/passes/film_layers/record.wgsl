// Records what the first surface of each path gives to the layers of the film: that from which the path was scattered
// first, or on which it ended. Rounds overwrite each other as long as nothing has scattered the path, so that surfaces
// which it passes (holes, clear walls, borders inside bodies) count no more than for the picture. One thread per path that
// is under way, before the surface is shaded.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include shared/abilities.wgsl
//!include shared/appearance.wgsl
//!include shared/node_values.wgsl
//!include film_layers/samples.wgsl
//!include film_layers/words.wgsl
//!include generated/film_layers.wgsl

// The surface, with what its texture program said.
struct FirstSurface {
    slot: u32,
    instance: u32,
    surface: Surface,
    material: u32, // after blends
    driven: u32, // outputs that the program gave
    has_program: bool,
}

// What the look of the surface is made from. All of it is read at once.
const FIRST_BASE_TEXTURES = 1u << TEXTURE_BASE_COLOR;
const FIRST_NORMAL_TEXTURES = 1u << TEXTURE_NORMAL;
const FIRST_COLORS_TEXTURES = (1u << TEXTURE_BASE_COLOR) | (1u << TEXTURE_METALLIC_ROUGHNESS) | (1u << TEXTURE_SPECULAR)
    | (1u << TEXTURE_SPECULAR_COLOR);

fn first_texels(at: FirstSurface, wanted: u32) -> array<vec4f, FIRST_LAYER_TEXTURE> {
    return material_textures(at.material, wanted, at.surface.triangle, at.surface.weights);
}

fn first_normal(at: FirstSurface, texels: array<vec4f, FIRST_LAYER_TEXTURE>) -> vec3f {
    return shading_normal_at(at.slot, at.driven, at.material, at.surface, at.instance, texels[TEXTURE_NORMAL]);
}

fn in_camera_axes(v: vec3f) -> vec3f {
    return vec3f(dot(v, frame.camera_right), dot(v, frame.camera_up), dot(v, frame.camera_back));
}

fn first_base(at: FirstSurface, texels: array<vec4f, FIRST_LAYER_TEXTURE>) -> vec3f {
    return base_color_at(at.slot, at.driven, at.material, at.surface, texels[TEXTURE_BASE_COLOR]);
}

// The colours by which the surface scatters light diffusely, reflects it when seen straight on, and lets it through.
struct FirstColors {
    diffuse: vec3f,
    glossy: vec3f,
    transmission: vec3f,
}

fn first_colors(at: FirstSurface, texels: array<vec4f, FIRST_LAYER_TEXTURE>) -> FirstColors {
    if ((materials[at.material].flags & MATERIAL_UNLIT) != 0u) {
        return FirstColors(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    }
    let base = saturate(first_base(at, texels));
    let metallic = saturate(metallic_at(at.slot, at.driven, at.material, texels[TEXTURE_METALLIC_ROUGHNESS]));
    var transmission = 0.0;
    var back = 0.0;
    var back_color = vec3f(0.0);
    if (has_transmission) {
        let layers = layer_textures(at.material, at.surface.triangle, at.surface.weights);
        transmission = saturate(scalar_or(at.slot, at.driven, OUTPUT_TRANSMISSION,
            materials[at.material].transmission * layers[LAYER_TRANSMISSION].x));
        back = saturate(scalar_or(at.slot, at.driven, OUTPUT_DIFFUSE_TRANSMISSION,
            materials[at.material].diffuse_transmission * layers[LAYER_DIFFUSE_TRANSMISSION].w));
        back_color = saturate(color_or(at.slot, at.driven, OUTPUT_DIFFUSE_TRANSMISSION_COLOR,
            materials[at.material].diffuse_transmission_color * layers[LAYER_DIFFUSE_TRANSMISSION_COLOR].xyz));
    }
    let specular = scalar_or(at.slot, at.driven, OUTPUT_SPECULAR,
        materials[at.material].specular * texels[TEXTURE_SPECULAR].w);
    let specular_color = color_or(at.slot, at.driven, OUTPUT_SPECULAR_COLOR,
        materials[at.material].specular_color * texels[TEXTURE_SPECULAR_COLOR].xyz);
    var f0 = materials[at.material].dielectric_f0;
    if (gives(at.slot, at.driven, OUTPUT_IOR)) {
        let ior = max(scalar_or(at.slot, at.driven, OUTPUT_IOR, 1.0), 0.0);
        let ratio = (ior - 1.0) / (ior + 1.0);
        f0 = ratio * ratio;
    }
    let dielectric = saturate(specular) * min(f0 * specular_color, vec3f(1.0));
    let body = 1.0 - metallic;
    return FirstColors(mix(base, back_color, back) * (body * (1.0 - transmission)), mix(dielectric, base, metallic),
        base * (body * transmission));
}

// glTF counts v from the upper edge of a picture.
fn first_uv(at: FirstSurface) -> vec2f {
    let uv = interpolate_uv(at.surface.triangle, at.surface.weights, 0u);
    return vec2f(uv.x, 1.0 - uv.y);
}

// Where the camera shows a place in its own axes: pixels from the middle of the picture, to the right and up.
fn shown_at(p: vec3f) -> vec2f {
    let place = p.xy * (0.5 * whole_size().y / frame.half_height);
    return select(place / max(-p.z, 1e-20), place, frame.orthographic != 0u);
}

// Where the surface's point is in the object, where the list of the vertices' places at another moment begins at `first`. The record of
// the motion says where the mesh's own vertices begin, and how many records each has.
fn bent_position(at: FirstSurface, motion: u32, first: u32) -> vec3f {
    let v = vec3u(first) + (at.surface.triangle.xyz - vec3u(instances[motion].id)) / instances[motion].asset;
    return mat3x3f(vertex_position(v.x), vertex_position(v.y), vertex_position(v.z)) * at.surface.weights;
}

// Where the surface's point was a frame ago, seen from where it is now, and where it is now, seen from where it will be in a frame:
// pixels, as Cycles counts them.
fn first_motion(at: FirstSurface) -> vec4f {
    let motion = instances[at.instance].motion;
    if (motion == 0u) {
        return vec4f(0.0);
    }
    let t = at.surface.triangle;
    let p = mat3x3f(vertex_position(t.x), vertex_position(t.y), vertex_position(t.z)) * at.surface.weights;
    var was = p;
    var will_be = p;
    if (instances[motion].root != 0u) {
        was = bent_position(at, motion, instances[motion].root);
        will_be = bent_position(at, motion, instances[motion].source);
    }
    let before = transform_point(instances[motion].world_from_object, was);
    let now = transform_point(instances[motion].object_from_world, p);
    let after = transform_point(instances[motion + 1u].world_from_object, will_be);
    // Nobody knows where something appears that is behind the camera.
    let is_flat = frame.orthographic != 0u;
    let place = shown_at(now);
    let since = select(vec2f(0.0), shown_at(before) - place, is_flat || before.z < 0.0);
    let until = select(vec2f(0.0), place - shown_at(after), is_flat || after.z < 0.0);
    return vec4f(since, until);
}

// Of the object's own material, as what is emitted: not what a blend has made of it.
fn first_caught(at: FirstSurface) -> f32 {
    let flags = materials[at.surface.triangle.w & TRIANGLE_MATERIAL].flags;
    return select(0.0, 1.0, (flags & MATERIAL_SHADOW_CATCHER) != 0u);
}

// Of a node by its number from 1 on.
fn node_value(at: FirstSurface, number: u32) -> vec4f {
    if (!at.has_program) {
        return vec4f(0.0);
    }
    return path_read(node_field(number - 1u), at.slot);
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
    var at = FirstSurface(slot, hit.instance, surface, own_material, 0u, false);
    if (runs_program(materials[own_material].flags, frame.max_depth == 0u)) {
        let resolved = path_words(PATH_STATE, slot);
        at.material = resolved.x;
        at.driven = resolved.y;
        at.has_program = true;
    }
    record_each(at);
}
