// Parts of a piece of light, by how it came: what the declarations of layers are written in.
//!include shared/found_light.wgsl

// By what the first surface has done with it.
fn diffuse(found: Found) -> vec3f {
    return found.light * found.diffuse;
}

fn glossy(found: Found) -> vec3f {
    return select(vec3f(0.0), found.light * (vec3f(1.0) - found.diffuse), found.is_above);
}

fn transmission(found: Found) -> vec3f {
    return select(found.light * (vec3f(1.0) - found.diffuse), vec3f(0.0), found.is_above);
}

// A part, where the lamp's light came to the first surface without detour, or with one.
fn direct(part: vec3f, found: Found) -> vec3f {
    return select(vec3f(0.0), part, found.scatterings == 1u);
}

fn indirect(part: vec3f, found: Found) -> vec3f {
    return select(vec3f(0.0), part, found.scatterings > 1u);
}

// What nothing has scattered.
fn emitted(found: Found) -> vec3f {
    return select(vec3f(0.0), found.light, found.scatterings == 0u && found.is_surface);
}

fn from_far(found: Found) -> vec3f {
    return select(vec3f(0.0), found.light, found.scatterings == 0u && !found.is_surface);
}
