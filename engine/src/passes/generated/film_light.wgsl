// From the table of layers; `cargo test -p engine generated` writes it.

fn word_caught() -> u32 {
    return layer_words[6].w;
}

fn word_diffuse_direct() -> u32 {
    return layer_words[2].x;
}

fn word_diffuse_indirect() -> u32 {
    return layer_words[2].y;
}

fn word_glossy_direct() -> u32 {
    return layer_words[2].w;
}

fn word_glossy_indirect() -> u32 {
    return layer_words[3].x;
}

fn word_transmission_direct() -> u32 {
    return layer_words[3].z;
}

fn word_transmission_indirect() -> u32 {
    return layer_words[3].w;
}

fn word_emission() -> u32 {
    return layer_words[4].y;
}

fn word_environment() -> u32 {
    return layer_words[4].z;
}

fn word_caught_light() -> u32 {
    return layer_words[7].x;
}

fn word_caught_shadowless() -> u32 {
    return layer_words[7].y;
}

fn word_caught_arrived() -> u32 {
    return layer_words[7].z;
}

fn group_word(group: u32) -> u32 {
    if (group >= 16u) {
        return 0u;
    }
    let place = 33u + group;
    return layer_words[place / 4u][place % 4u];
}

fn add_found(slot: u32, found: Found) {
    if (word_diffuse_direct() != 0u) {
        layer_add(word_diffuse_direct(), 0x1u, slot, direct(diffuse(found), found));
    }
    if (word_diffuse_indirect() != 0u) {
        layer_add(word_diffuse_indirect(), 0x2u, slot, indirect(diffuse(found), found));
    }
    if (word_glossy_direct() != 0u) {
        layer_add(word_glossy_direct(), 0x4u, slot, direct(glossy(found), found));
    }
    if (word_glossy_indirect() != 0u) {
        layer_add(word_glossy_indirect(), 0x8u, slot, indirect(glossy(found), found));
    }
    if (word_transmission_direct() != 0u) {
        layer_add(word_transmission_direct(), 0x10u, slot, direct(transmission(found), found));
    }
    if (word_transmission_indirect() != 0u) {
        layer_add(word_transmission_indirect(), 0x20u, slot, indirect(transmission(found), found));
    }
    if (word_emission() != 0u) {
        layer_add(word_emission(), 0x40u, slot, emitted(found));
    }
    if (word_environment() != 0u) {
        layer_add(word_environment(), 0x80u, slot, from_far(found));
    }
    if (word_caught_light() != 0u) {
        layer_add(word_caught_light(), 0x100u, slot, select(vec3f(0.0), found.light, is_caught(slot)));
    }
    if (word_caught_shadowless() != 0u) {
        layer_add(word_caught_shadowless(), 0x200u, slot, found.shadowless);
    }
    if (word_caught_arrived() != 0u) {
        layer_add(word_caught_arrived(), 0x400u, slot, found.arrived);
    }
    if (group_word(found.group) != 0u) {
        layer_add(group_word(found.group), 0x800u << found.group, slot, found.light);
    }
}
