// From the table of layers; `cargo test -p engine generated` writes it.

fn word_depth() -> u32 {
    return layer_words[0].y;
}

fn word_position() -> u32 {
    return layer_words[0].z;
}

fn word_normal() -> u32 {
    return layer_words[0].w;
}

fn word_uv() -> u32 {
    return layer_words[1].x;
}

fn word_albedo() -> u32 {
    return layer_words[1].y;
}

fn word_denoising_normal() -> u32 {
    return layer_words[1].z;
}

fn word_denoising_depth() -> u32 {
    return layer_words[1].w;
}

fn word_diffuse_color() -> u32 {
    return layer_words[2].z;
}

fn word_glossy_color() -> u32 {
    return layer_words[3].y;
}

fn word_transmission_color() -> u32 {
    return layer_words[4].x;
}

fn word_alpha() -> u32 {
    return layer_words[4].w;
}

fn word_crypto_object() -> u32 {
    return layer_words[5].x;
}

fn word_crypto_material() -> u32 {
    return layer_words[5].y;
}

fn word_crypto_asset() -> u32 {
    return layer_words[5].z;
}

fn word_object_index() -> u32 {
    return layer_words[5].w;
}

fn word_material_index() -> u32 {
    return layer_words[6].x;
}

fn word_caught() -> u32 {
    return layer_words[6].w;
}

fn word_vector() -> u32 {
    return layer_words[7].w;
}

fn word_vector_next() -> u32 {
    return layer_words[8].x;
}

fn word_node_1() -> u32 {
    return layer_words[12].y;
}

fn word_node_1_alpha() -> u32 {
    return layer_words[12].z;
}

fn word_node_2() -> u32 {
    return layer_words[12].w;
}

fn word_node_2_alpha() -> u32 {
    return layer_words[13].x;
}

fn word_node_3() -> u32 {
    return layer_words[13].y;
}

fn word_node_3_alpha() -> u32 {
    return layer_words[13].z;
}

fn word_node_4() -> u32 {
    return layer_words[13].w;
}

fn word_node_4_alpha() -> u32 {
    return layer_words[14].x;
}

fn word_node_5() -> u32 {
    return layer_words[14].y;
}

fn word_node_5_alpha() -> u32 {
    return layer_words[14].z;
}

fn word_node_6() -> u32 {
    return layer_words[14].w;
}

fn word_node_6_alpha() -> u32 {
    return layer_words[15].x;
}

fn word_node_7() -> u32 {
    return layer_words[15].y;
}

fn word_node_7_alpha() -> u32 {
    return layer_words[15].z;
}

fn word_node_8() -> u32 {
    return layer_words[15].w;
}

fn word_node_8_alpha() -> u32 {
    return layer_words[16].x;
}

fn record_each(at: FirstSurface) {
    let wants_base = word_albedo() != 0u;
    let wants_normal = word_normal() != 0u || word_denoising_normal() != 0u;
    let wants_colors = word_diffuse_color() != 0u || word_glossy_color() != 0u || word_transmission_color() != 0u;
    let texels = first_texels(at, select(0u, FIRST_BASE_TEXTURES, wants_base)
        | select(0u, FIRST_NORMAL_TEXTURES, wants_normal)
        | select(0u, FIRST_COLORS_TEXTURES, wants_colors));
    var base: vec3f;
    if (wants_base) {
        base = first_base(at, texels);
    }
    var normal: vec3f;
    if (wants_normal) {
        normal = first_normal(at, texels);
    }
    var colors: FirstColors;
    if (wants_colors) {
        colors = first_colors(at, texels);
    }
    if (word_depth() != 0u) {
        let value: f32 = dot(frame.camera_position - at.surface.position, frame.camera_back);
        layer_sample_set(word_depth() + 0u, at.slot, value);
    }
    if (word_position() != 0u) {
        let value: vec3f = at.surface.position;
        layer_sample_set(word_position() + 0u, at.slot, value.x);
        layer_sample_set(word_position() + 1u, at.slot, value.y);
        layer_sample_set(word_position() + 2u, at.slot, value.z);
    }
    if (word_normal() != 0u) {
        let value: vec3f = normal;
        layer_sample_set(word_normal() + 0u, at.slot, value.x);
        layer_sample_set(word_normal() + 1u, at.slot, value.y);
        layer_sample_set(word_normal() + 2u, at.slot, value.z);
    }
    if (word_uv() != 0u) {
        let value: vec3f = vec3f(first_uv(at), 1.0);
        layer_sample_set(word_uv() + 0u, at.slot, value.x);
        layer_sample_set(word_uv() + 1u, at.slot, value.y);
        layer_sample_set(word_uv() + 2u, at.slot, value.z);
    }
    if (word_albedo() != 0u) {
        let value: vec3f = base;
        layer_sample_set(word_albedo() + 0u, at.slot, value.x);
        layer_sample_set(word_albedo() + 1u, at.slot, value.y);
        layer_sample_set(word_albedo() + 2u, at.slot, value.z);
    }
    if (word_denoising_normal() != 0u) {
        let value: vec3f = in_camera_axes(normal);
        layer_sample_set(word_denoising_normal() + 0u, at.slot, value.x);
        layer_sample_set(word_denoising_normal() + 1u, at.slot, value.y);
        layer_sample_set(word_denoising_normal() + 2u, at.slot, value.z);
    }
    if (word_denoising_depth() != 0u) {
        let value: f32 = dot(frame.camera_position - at.surface.position, frame.camera_back);
        layer_sample_set(word_denoising_depth() + 0u, at.slot, value);
    }
    if (word_diffuse_color() != 0u) {
        let value: vec3f = colors.diffuse;
        layer_sample_set(word_diffuse_color() + 0u, at.slot, value.x);
        layer_sample_set(word_diffuse_color() + 1u, at.slot, value.y);
        layer_sample_set(word_diffuse_color() + 2u, at.slot, value.z);
    }
    if (word_glossy_color() != 0u) {
        let value: vec3f = colors.glossy;
        layer_sample_set(word_glossy_color() + 0u, at.slot, value.x);
        layer_sample_set(word_glossy_color() + 1u, at.slot, value.y);
        layer_sample_set(word_glossy_color() + 2u, at.slot, value.z);
    }
    if (word_transmission_color() != 0u) {
        let value: vec3f = colors.transmission;
        layer_sample_set(word_transmission_color() + 0u, at.slot, value.x);
        layer_sample_set(word_transmission_color() + 1u, at.slot, value.y);
        layer_sample_set(word_transmission_color() + 2u, at.slot, value.z);
    }
    if (word_alpha() != 0u) {
        let value: f32 = 1.0;
        layer_sample_set(word_alpha() + 0u, at.slot, value);
    }
    if (word_crypto_object() != 0u) {
        let value: u32 = instances[at.instance].id;
        layer_sample_set(word_crypto_object() + 0u, at.slot, bitcast<f32>(value));
    }
    if (word_crypto_material() != 0u) {
        let value: u32 = materials[at.material].id;
        layer_sample_set(word_crypto_material() + 0u, at.slot, bitcast<f32>(value));
    }
    if (word_crypto_asset() != 0u) {
        let value: u32 = instances[at.instance].asset;
        layer_sample_set(word_crypto_asset() + 0u, at.slot, bitcast<f32>(value));
    }
    if (word_object_index() != 0u) {
        let value: f32 = f32(instances[at.instance].source + 1u);
        layer_sample_set(word_object_index() + 0u, at.slot, value);
    }
    if (word_material_index() != 0u) {
        let value: f32 = f32(at.material + 1u);
        layer_sample_set(word_material_index() + 0u, at.slot, value);
    }
    if (word_caught() != 0u) {
        let value: f32 = first_caught(at);
        layer_sample_set(word_caught() + 0u, at.slot, value);
    }
    if (word_vector() != 0u) {
        let value: vec2f = first_motion(at).xy;
        layer_sample_set(word_vector() + 0u, at.slot, value.x);
        layer_sample_set(word_vector() + 1u, at.slot, value.y);
    }
    if (word_vector_next() != 0u) {
        let value: vec2f = first_motion(at).zw;
        layer_sample_set(word_vector_next() + 0u, at.slot, value.x);
        layer_sample_set(word_vector_next() + 1u, at.slot, value.y);
    }
    if (word_node_1() != 0u) {
        let value: vec3f = node_value(at, 1u).xyz;
        layer_sample_set(word_node_1() + 0u, at.slot, value.x);
        layer_sample_set(word_node_1() + 1u, at.slot, value.y);
        layer_sample_set(word_node_1() + 2u, at.slot, value.z);
    }
    if (word_node_1_alpha() != 0u) {
        let value: f32 = node_value(at, 1u).w;
        layer_sample_set(word_node_1_alpha() + 0u, at.slot, value);
    }
    if (word_node_2() != 0u) {
        let value: vec3f = node_value(at, 2u).xyz;
        layer_sample_set(word_node_2() + 0u, at.slot, value.x);
        layer_sample_set(word_node_2() + 1u, at.slot, value.y);
        layer_sample_set(word_node_2() + 2u, at.slot, value.z);
    }
    if (word_node_2_alpha() != 0u) {
        let value: f32 = node_value(at, 2u).w;
        layer_sample_set(word_node_2_alpha() + 0u, at.slot, value);
    }
    if (word_node_3() != 0u) {
        let value: vec3f = node_value(at, 3u).xyz;
        layer_sample_set(word_node_3() + 0u, at.slot, value.x);
        layer_sample_set(word_node_3() + 1u, at.slot, value.y);
        layer_sample_set(word_node_3() + 2u, at.slot, value.z);
    }
    if (word_node_3_alpha() != 0u) {
        let value: f32 = node_value(at, 3u).w;
        layer_sample_set(word_node_3_alpha() + 0u, at.slot, value);
    }
    if (word_node_4() != 0u) {
        let value: vec3f = node_value(at, 4u).xyz;
        layer_sample_set(word_node_4() + 0u, at.slot, value.x);
        layer_sample_set(word_node_4() + 1u, at.slot, value.y);
        layer_sample_set(word_node_4() + 2u, at.slot, value.z);
    }
    if (word_node_4_alpha() != 0u) {
        let value: f32 = node_value(at, 4u).w;
        layer_sample_set(word_node_4_alpha() + 0u, at.slot, value);
    }
    if (word_node_5() != 0u) {
        let value: vec3f = node_value(at, 5u).xyz;
        layer_sample_set(word_node_5() + 0u, at.slot, value.x);
        layer_sample_set(word_node_5() + 1u, at.slot, value.y);
        layer_sample_set(word_node_5() + 2u, at.slot, value.z);
    }
    if (word_node_5_alpha() != 0u) {
        let value: f32 = node_value(at, 5u).w;
        layer_sample_set(word_node_5_alpha() + 0u, at.slot, value);
    }
    if (word_node_6() != 0u) {
        let value: vec3f = node_value(at, 6u).xyz;
        layer_sample_set(word_node_6() + 0u, at.slot, value.x);
        layer_sample_set(word_node_6() + 1u, at.slot, value.y);
        layer_sample_set(word_node_6() + 2u, at.slot, value.z);
    }
    if (word_node_6_alpha() != 0u) {
        let value: f32 = node_value(at, 6u).w;
        layer_sample_set(word_node_6_alpha() + 0u, at.slot, value);
    }
    if (word_node_7() != 0u) {
        let value: vec3f = node_value(at, 7u).xyz;
        layer_sample_set(word_node_7() + 0u, at.slot, value.x);
        layer_sample_set(word_node_7() + 1u, at.slot, value.y);
        layer_sample_set(word_node_7() + 2u, at.slot, value.z);
    }
    if (word_node_7_alpha() != 0u) {
        let value: f32 = node_value(at, 7u).w;
        layer_sample_set(word_node_7_alpha() + 0u, at.slot, value);
    }
    if (word_node_8() != 0u) {
        let value: vec3f = node_value(at, 8u).xyz;
        layer_sample_set(word_node_8() + 0u, at.slot, value.x);
        layer_sample_set(word_node_8() + 1u, at.slot, value.y);
        layer_sample_set(word_node_8() + 2u, at.slot, value.z);
    }
    if (word_node_8_alpha() != 0u) {
        let value: f32 = node_value(at, 8u).w;
        layer_sample_set(word_node_8_alpha() + 0u, at.slot, value);
    }
}
