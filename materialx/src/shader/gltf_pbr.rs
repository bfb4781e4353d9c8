//! The model of glTF 2.0 with its extensions.

use crate::value::Value;

use super::surface::Surface;

/// What the model has.
pub(super) const INPUTS: &[&str] = &[
    "base_color",
    "metallic",
    "roughness",
    "normal",
    "tangent",
    "occlusion",
    "transmission",
    "specular",
    "specular_color",
    "ior",
    "alpha",
    "alpha_mode",
    "alpha_cutoff",
    "iridescence",
    "iridescence_ior",
    "iridescence_thickness",
    "sheen_color",
    "sheen_roughness",
    "clearcoat",
    "clearcoat_roughness",
    "clearcoat_normal",
    "emissive",
    "emissive_strength",
    "thickness",
    "attenuation_distance",
    "attenuation_color",
    "anisotropy_strength",
    "anisotropy_rotation",
    "dispersion",
];

pub(super) fn convert(s: &mut Surface<'_, '_>) {
    let color = s.color("base_color", 1.0);
    s.set_color("base_color", &color, 1.0);
    let metallic = s.number("metallic", 1.0);
    s.set("metallic", &metallic, 0.0, 1.0);
    let roughness = s.number("roughness", 1.0);
    s.set("roughness", &roughness, 0.0, 1.0);
    let specular = s.number("specular", 1.0);
    s.set("specular", &specular, 0.0, 1.0);
    let color = s.color("specular_color", 1.0);
    s.set_color("specular_color", &color, f32::MAX);
    let ior = s.number("ior", 1.5);
    s.set("ior", &ior, 1.0, f32::MAX);
    let transmission = s.number("transmission", 0.0);
    let thickness = s.number("thickness", 0.0);
    if !transmission.is(0.0) {
        s.set("transmission", &transmission, 0.0, 1.0);
        s.set_flag("solid", !thickness.is(0.0));
        attenuation(s);
    }
    alpha(s);
    let iridescence = s.number("iridescence", 0.0);
    if !iridescence.is(0.0) {
        s.set("iridescence", &iridescence, 0.0, 1.0);
        let thickness = s.number("iridescence_thickness", 100.0);
        s.set("iridescence_thickness", &thickness, 0.0, f32::MAX);
        let ior = s.number("iridescence_ior", 1.3);
        s.set("iridescence_ior", &ior, 1.0, f32::MAX);
    }
    let sheen = s.color("sheen_color", 0.0);
    if !sheen.is(0.0) {
        s.set_color("sheen_color", &sheen, 1.0);
        let roughness = s.number("sheen_roughness", 0.0);
        s.set("sheen_roughness", &roughness, 0.0, 1.0);
    }
    let coat = s.number("clearcoat", 0.0);
    if !coat.is(0.0) {
        s.set("coat", &coat, 0.0, 1.0);
        let roughness = s.number("clearcoat_roughness", 0.0);
        s.set("coat_roughness", &roughness, 0.0, 1.0);
        s.warn_of_coat_normal("clearcoat_normal");
    }
    let anisotropy = s.number("anisotropy_strength", 0.0);
    if !anisotropy.is(0.0) {
        s.set("anisotropy", &anisotropy, 0.0, 1.0);
        let radians = s.number("anisotropy_rotation", 0.0);
        let degrees = s.product("rotation", &radians, &Value::number(1f32.to_degrees()));
        s.set("anisotropy_rotation", &degrees, -360.0, 360.0);
        s.ignores_link(
            "tangent",
            "reflections stretch along the texture coordinates",
        );
    }
    s.ignores_node("dispersion", "all colours are refracted alike");
    let dispersion = s.number("dispersion", 0.0);
    if dispersion.known().is_some() {
        s.set_unless("dispersion", &dispersion, 0.0, f32::MAX);
    }
    let (strength, color) = (s.number("emissive_strength", 1.0), s.color("emissive", 0.0));
    s.emission(&strength, &color);
    s.normal("normal");
}

/// What the body absorbs, by a colour and the way after which light has it.
fn attenuation(s: &mut Surface<'_, '_>) {
    let distance = s.number("attenuation_distance", 0.0);
    let color = s.color("attenuation_color", 1.0);
    // What a node drives may be any distance.
    let absorbs = (distance.known()).is_none_or(|distance| distance[0] > 0.0 && distance[0] < 1e30);
    if !absorbs {
        return;
    }
    if let (Some([r, g, b, _]), Some(_)) = (color.known(), distance.known()) {
        let held = Value::color([r, g, b].map(|c| c.clamp(1e-4, 1.0)));
        s.set_color("attenuation_color", &held, 1.0);
        s.set("attenuation_distance", &distance, 1e-6, f32::MAX);
    } else if !color.is(1.0) {
        for input in ["attenuation_color", "attenuation_distance"] {
            s.ignores_node(input, "the body absorbs nothing");
        }
    }
}

fn alpha(s: &mut Surface<'_, '_>) {
    let alpha = s.number("alpha", 1.0);
    let mode = s
        .number("alpha_mode", 0.0)
        .known()
        .map_or(0.0, |mode| mode[0]);
    if mode == 2.0 {
        s.opacity(&alpha);
    } else if mode == 1.0 {
        let cutoff = s.number("alpha_cutoff", 0.5);
        s.cut(&alpha, &cutoff);
    }
}
