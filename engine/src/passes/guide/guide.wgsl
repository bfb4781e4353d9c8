// Keeps what the camera's rays hit first, for a window to show. One thread per path of a wave of one sample, whose texture
// programs have run.
//!include shared/wave_memory.wgsl
//!include shared/appearance.wgsl

// Two of each pixel: distance, material, instance (both MISS where nothing was hit) and the octahedral shading normal;
// base colour, roughness and metallic in 16 bits each, and emission with a shared exponent.
@group(0) @binding(5) var<storage, read_write> guides: array<vec4u>;

@compute @workgroup_size(64)
fn guide(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
         @builtin(local_invocation_index) local: u32) {
    let slot = thread_index(workgroup, workgroups, local);
    if (slot >= frame.wave_size) {
        return;
    }
    let pixel = pixel_coordinates(path_id(slot).pixel);
    if (!is_rendered(pixel)) {
        return;
    }
    let at = 2u * (pixel.y * frame.width + pixel.x);
    let hit = rays[own_ray(slot)];
    if (hit.triangle == MISS) {
        guides[at] = vec4u(bitcast<u32>(1e30), MISS, MISS, 0u);
        guides[at + 1u] = vec4u(0u);
        return;
    }
    let s = surface_at(hit);
    let own_material = s.triangle.w & TRIANGLE_MATERIAL;
    var material = own_material;
    var driven = 0u;
    if (runs_program(materials[own_material].flags, frame.max_depth == 0u)) {
        let resolved = path_words(PATH_STATE, slot);
        material = resolved.x;
        driven = resolved.y;
    }
    let texels = material_textures(material, 0xffffffffu, s.triangle, s.weights);
    let normal = shading_normal_at(slot, driven, material, s, hit.instance, texels[TEXTURE_NORMAL]);
    let base_color = base_color_at(slot, driven, material, s, texels[TEXTURE_BASE_COLOR]);
    let roughness = roughness_at(slot, driven, material, texels[TEXTURE_METALLIC_ROUGHNESS]);
    let metallic = metallic_at(slot, driven, material, texels[TEXTURE_METALLIC_ROUGHNESS]);
    var emission = vec3f(0.0);
    if (s.front || (materials[material].flags & MATERIAL_DOUBLE_SIDED) != 0u) {
        emission = emission_at(slot, driven, material, texels[TEXTURE_EMISSION]);
    }
    guides[at] = vec4u(
        bitcast<u32>(hit.t_max),
        own_material,
        instances[hit.instance].source,
        octahedral_encode(normal));
    guides[at + 1u] = vec4u(
        pack2x16unorm(base_color.xy),
        pack2x16unorm(vec2f(base_color.z, roughness)),
        pack2x16unorm(vec2f(metallic, 0.0)),
        pack_shared_exponent(emission));
}

// Three numbers of 9 bits with one exponent of 5 bits (EXT_texture_shared_exponent, OpenGL extension 333): up to 65408.
fn pack_shared_exponent(color: vec3f) -> u32 {
    let c = clamp(color, vec3f(0.0), vec3f(65408.0));
    // The exponent is read from the largest number's bits; what rounds up to 2^9 takes the next one.
    let floor_log2 = i32(bitcast<u32>(max(max_component(c), 1e-30)) >> 23u) - 127;
    var exponent = max(floor_log2, -16) + 16;
    if (u32(round(max_component(c) * exp2(f32(24 - exponent)))) == 512u) {
        exponent += 1;
    }
    let bits = vec3u(round(c * exp2(f32(24 - exponent))));
    return bits.x | bits.y << 9u | bits.z << 18u | u32(exponent) << 27u;
}
