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

fn word_light_group_0() -> u32 {
    return layer_words[8].y;
}

fn word_light_group_1() -> u32 {
    return layer_words[8].z;
}

fn word_light_group_2() -> u32 {
    return layer_words[8].w;
}

fn word_light_group_3() -> u32 {
    return layer_words[9].x;
}

fn word_light_group_4() -> u32 {
    return layer_words[9].y;
}

fn word_light_group_5() -> u32 {
    return layer_words[9].z;
}

fn word_light_group_6() -> u32 {
    return layer_words[9].w;
}

fn word_light_group_7() -> u32 {
    return layer_words[10].x;
}

fn word_light_group_8() -> u32 {
    return layer_words[10].y;
}

fn word_light_group_9() -> u32 {
    return layer_words[10].z;
}

fn word_light_group_10() -> u32 {
    return layer_words[10].w;
}

fn word_light_group_11() -> u32 {
    return layer_words[11].x;
}

fn word_light_group_12() -> u32 {
    return layer_words[11].y;
}

fn word_light_group_13() -> u32 {
    return layer_words[11].z;
}

fn word_light_group_14() -> u32 {
    return layer_words[11].w;
}

fn word_light_group_15() -> u32 {
    return layer_words[12].x;
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
        layer_add(word_diffuse_direct(), slot, direct(diffuse(found), found));
    }
    if (word_diffuse_indirect() != 0u) {
        layer_add(word_diffuse_indirect(), slot, indirect(diffuse(found), found));
    }
    if (word_glossy_direct() != 0u) {
        layer_add(word_glossy_direct(), slot, direct(glossy(found), found));
    }
    if (word_glossy_indirect() != 0u) {
        layer_add(word_glossy_indirect(), slot, indirect(glossy(found), found));
    }
    if (word_transmission_direct() != 0u) {
        layer_add(word_transmission_direct(), slot, direct(transmission(found), found));
    }
    if (word_transmission_indirect() != 0u) {
        layer_add(word_transmission_indirect(), slot, indirect(transmission(found), found));
    }
    if (word_emission() != 0u) {
        layer_add(word_emission(), slot, emitted(found));
    }
    if (word_environment() != 0u) {
        layer_add(word_environment(), slot, from_far(found));
    }
    if (word_caught_light() != 0u) {
        layer_add(word_caught_light(), slot, select(vec3f(0.0), found.light, is_caught(slot)));
    }
    if (word_caught_shadowless() != 0u) {
        layer_add(word_caught_shadowless(), slot, found.shadowless);
    }
    if (word_caught_arrived() != 0u) {
        layer_add(word_caught_arrived(), slot, found.arrived);
    }
    if (group_word(found.group) != 0u) {
        layer_add(group_word(found.group), slot, found.light);
    }
}

fn forget_found(slot: u32) {
    if (word_diffuse_direct() != 0u) {
        layer_clear(word_diffuse_direct(), slot);
    }
    if (word_diffuse_indirect() != 0u) {
        layer_clear(word_diffuse_indirect(), slot);
    }
    if (word_glossy_direct() != 0u) {
        layer_clear(word_glossy_direct(), slot);
    }
    if (word_glossy_indirect() != 0u) {
        layer_clear(word_glossy_indirect(), slot);
    }
    if (word_transmission_direct() != 0u) {
        layer_clear(word_transmission_direct(), slot);
    }
    if (word_transmission_indirect() != 0u) {
        layer_clear(word_transmission_indirect(), slot);
    }
    if (word_emission() != 0u) {
        layer_clear(word_emission(), slot);
    }
    if (word_environment() != 0u) {
        layer_clear(word_environment(), slot);
    }
    if (word_caught_light() != 0u) {
        layer_clear(word_caught_light(), slot);
    }
    if (word_caught_shadowless() != 0u) {
        layer_clear(word_caught_shadowless(), slot);
    }
    if (word_caught_arrived() != 0u) {
        layer_clear(word_caught_arrived(), slot);
    }
    if (word_light_group_0() != 0u) {
        layer_clear(word_light_group_0(), slot);
    }
    if (word_light_group_1() != 0u) {
        layer_clear(word_light_group_1(), slot);
    }
    if (word_light_group_2() != 0u) {
        layer_clear(word_light_group_2(), slot);
    }
    if (word_light_group_3() != 0u) {
        layer_clear(word_light_group_3(), slot);
    }
    if (word_light_group_4() != 0u) {
        layer_clear(word_light_group_4(), slot);
    }
    if (word_light_group_5() != 0u) {
        layer_clear(word_light_group_5(), slot);
    }
    if (word_light_group_6() != 0u) {
        layer_clear(word_light_group_6(), slot);
    }
    if (word_light_group_7() != 0u) {
        layer_clear(word_light_group_7(), slot);
    }
    if (word_light_group_8() != 0u) {
        layer_clear(word_light_group_8(), slot);
    }
    if (word_light_group_9() != 0u) {
        layer_clear(word_light_group_9(), slot);
    }
    if (word_light_group_10() != 0u) {
        layer_clear(word_light_group_10(), slot);
    }
    if (word_light_group_11() != 0u) {
        layer_clear(word_light_group_11(), slot);
    }
    if (word_light_group_12() != 0u) {
        layer_clear(word_light_group_12(), slot);
    }
    if (word_light_group_13() != 0u) {
        layer_clear(word_light_group_13(), slot);
    }
    if (word_light_group_14() != 0u) {
        layer_clear(word_light_group_14(), slot);
    }
    if (word_light_group_15() != 0u) {
        layer_clear(word_light_group_15(), slot);
    }
}
