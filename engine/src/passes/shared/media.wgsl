// The bodies that a path is in. A path remembers four, the one entered last first, as 1 + material; 0 is nothing. Light
// travels in the one with the highest priority, among equals in the one entered last, so that a drink may overlap its
// glass (after Schmidt and Budge, "Simple Nested Dielectrics in Ray Traced Images", Journal of Graphics Tools 7(2), 2002).

fn media_hold(media: vec4u, material: u32) -> bool {
    return any(media == vec4u(material + 1u));
}

fn media_entered(media: vec4u, material: u32) -> vec4u {
    return vec4u(material + 1u, media.xyz);
}

// Without the body that was entered last of those made of this material.
fn media_left(media: vec4u, material: u32) -> vec4u {
    let own = media == vec4u(material + 1u);
    if (own.x) {
        return vec4u(media.yzw, 0u);
    }
    if (own.y) {
        return vec4u(media.x, media.zw, 0u);
    }
    if (own.z) {
        return vec4u(media.xy, media.w, 0u);
    }
    return vec4u(media.xyz, select(media.w, 0u, own.w));
}

// Behind the surface of a body.
fn media_behind(is_inside: bool, media: vec4u, material: u32) -> vec4u {
    if (is_inside) {
        return media_left(media, material);
    }
    return media_entered(media, material);
}

// Where light travels: 1 + material, or 0 in the air.
fn medium_among(media: vec4u) -> u32 {
    var medium = media.x;
    for (var i = 1u; i < 4u; i++) {
        let other = media[i];
        if (other != 0u && (medium == 0u || materials[other - 1u].priority > materials[medium - 1u].priority)) {
            medium = other;
        }
    }
    return medium;
}

// What is left of light after some metres of a medium.
fn medium_transmittance(medium: u32, distance: f32) -> vec3f {
    if (medium == 0u) {
        return vec3f(1.0);
    }
    return exp(-materials[medium - 1u].absorption * distance);
}

// KHR_materials_dispersion, with its three indices spread to a line: `hue` is 0 for red, 0.5 for green, 1 for blue.
fn dispersed(ior: f32, dispersion: f32, hue: f32) -> f32 {
    return max(ior + (ior - 1.0) * 0.025 * dispersion * (2.0 * hue - 1.0), 1.0);
}

// One hue for a whole path, and what it weighs in each channel. A channel responds to the hues within half a unit of its
// own, least at the ends; the mean over all hues is white.
const HUE_OFFSET = 2.0; // of the hue in a path's state, where 0 stands for all hues

fn hue_of(u: vec2f) -> f32 {
    let channel = min(floor(u.x * 3.0), 2.0);
    return 0.5 * channel + 0.5 * (u.x * 3.0 - channel + u.y - 1.0);
}

fn hue_weight(hue: f32) -> vec3f {
    let response = max(vec3f(1.0) - 2.0 * abs(vec3f(0.0, 0.5, 1.0) - hue), vec3f(0.0));
    return response * (3.0 / max(response.x + response.y + response.z, 1e-6));
}
