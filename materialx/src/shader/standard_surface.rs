//! Autodesk Standard Surface, versions 1.0.0 and 1.0.1 (Georgiev and others, 2019).

use crate::value::Value;

use super::surface::Surface;

/// What the model has.
pub(super) const INPUTS: &[&str] = &[
    "base",
    "base_color",
    "diffuse_roughness",
    "metalness",
    "specular",
    "specular_color",
    "specular_roughness",
    "specular_IOR",
    "specular_anisotropy",
    "specular_rotation",
    "transmission",
    "transmission_color",
    "transmission_depth",
    "transmission_scatter",
    "transmission_scatter_anisotropy",
    "transmission_dispersion",
    "transmission_extra_roughness",
    "subsurface",
    "subsurface_color",
    "subsurface_radius",
    "subsurface_scale",
    "subsurface_anisotropy",
    "sheen",
    "sheen_color",
    "sheen_roughness",
    "coat",
    "coat_color",
    "coat_roughness",
    "coat_anisotropy",
    "coat_rotation",
    "coat_IOR",
    "coat_normal",
    "coat_affect_color",
    "coat_affect_roughness",
    "thin_film_thickness",
    "thin_film_IOR",
    "emission",
    "emission_color",
    "opacity",
    "thin_walled",
    "normal",
    "tangent",
];

pub(super) fn convert(s: &mut Surface<'_, '_>) {
    // The first version has these two the other way round.
    let defaults = match s.is_of_version("1") {
        true => (0.8, 1.0),
        false => (1.0, 0.8),
    };
    let (base, color) = (
        s.number("base", defaults.0),
        s.color("base_color", defaults.1),
    );
    let mut body = s.product("base", &color, &base);
    let subsurface = s.number("subsurface", 0.0);
    let is_thin = s.is_on("thin_walled");
    if !subsurface.is(0.0) {
        let color = s.color("subsurface_color", 1.0);
        if is_thin {
            // What isn't reflected by the base goes through.
            s.set("diffuse_transmission", &subsurface, 0.0, 1.0);
            s.set_color("diffuse_transmission_color", &color, 1.0);
        } else {
            body = s.mixed("subsurface", &body, &color, &subsurface);
            s.warn(
                "subsurface",
                "subsurface scattering is shown as a diffuse surface of its colour",
            );
        }
    }
    let (weight, color) = (
        s.number("transmission", 0.0),
        s.color("transmission_color", 1.0),
    );
    let depth = s.number("transmission_depth", 0.0);
    let body = s.transmission(&weight, &color, &depth, is_thin, body);
    let (coat, coat_color) = (s.number("coat", 0.0), s.color("coat_color", 1.0));
    let body = s.below_coat("coated_base", &body, &coat, &coat_color);
    s.set_color("base_color", &body, 1.0);
    let metalness = s.number("metalness", 0.0);
    s.set("metallic", &metalness, 0.0, 1.0);
    let roughness = s.number("specular_roughness", 0.2);
    let anisotropy = s.number("specular_anisotropy", 0.0);
    s.roughness(&roughness, &anisotropy, widths);
    let specular = s.number("specular", 1.0);
    s.set("specular", &specular, 0.0, 1.0);
    let color = s.color("specular_color", 1.0);
    let color = s.below_coat("coated_specular", &color, &coat, &coat_color);
    s.set_color("specular_color", &color, f32::MAX);
    let ior = s.number("specular_IOR", 1.5);
    s.set("ior", &ior, 1.0, f32::MAX);
    if !anisotropy.is(0.0) {
        let turns = s.number("specular_rotation", 0.0);
        // MaterialX turns the tangent clockwise, glTF counter-clockwise.
        let degrees = s.product("rotation", &turns, &Value::number(-360.0));
        s.set("anisotropy_rotation", &degrees, -360.0, 360.0);
        s.ignores_link(
            "tangent",
            "reflections stretch along the texture coordinates",
        );
    }
    s.ignores_node("transmission_dispersion", "all colours are refracted alike");
    let abbe = s.number("transmission_dispersion", 0.0).known();
    if let Some([abbe, ..]) = abbe.filter(|abbe| abbe[0] > 0.0) {
        s.set("dispersion", &Value::number(20.0 / abbe), 0.0, f32::MAX);
    }
    coat_reflection(s);
    let (sheen, color) = (s.number("sheen", 0.0), s.color("sheen_color", 1.0));
    if !sheen.is(0.0) {
        let color = s.product("sheen", &color, &sheen);
        s.set_color("sheen_color", &color, 1.0);
        let roughness = s.number("sheen_roughness", 0.3);
        s.set("sheen_roughness", &roughness, 0.0, 1.0);
    }
    let thickness = s.number("thin_film_thickness", 0.0);
    if !thickness.is(0.0) {
        s.set("iridescence", &Value::number(1.0), 0.0, 1.0);
        s.set("iridescence_thickness", &thickness, 0.0, f32::MAX);
        let ior = s.number("thin_film_IOR", 1.5);
        s.set("iridescence_ior", &ior, 1.0, f32::MAX);
    }
    let (weight, color) = (s.number("emission", 0.0), s.color("emission_color", 1.0));
    s.emission(&weight, &color);
    let opacity = s.color("opacity", 1.0);
    s.opacity(&opacity);
    s.normal("normal");
    if is_thin {
        s.thin_wall();
    }
    s.ignores("diffuse_roughness", 0.0, "diffuse surfaces are Lambertian");
    s.ignores("transmission_scatter", 0.0, "bodies don't scatter");
    s.ignores(
        "transmission_extra_roughness",
        0.0,
        "transmission is as rough as the reflection",
    );
}

/// Widths of reflections along the tangent and across it: MaterialX's `roughness_anisotropy`.
fn widths(roughness: f32, anisotropy: f32) -> [f32; 2] {
    let aspect = (1.0 - anisotropy.min(0.98)).sqrt();
    let square = roughness * roughness;
    [square / aspect, square * aspect]
}

fn coat_reflection(s: &mut Surface<'_, '_>) {
    let coat = s.number("coat", 0.0);
    if coat.is(0.0) {
        return;
    }
    s.set("coat", &coat, 0.0, 1.0);
    let roughness = s.number("coat_roughness", 0.1);
    s.set("coat_roughness", &roughness, 0.0, 1.0);
    s.ignores("coat_IOR", 1.5, "the coat's index of refraction is 1.5");
    s.ignores(
        "coat_anisotropy",
        0.0,
        "the coat reflects alike in all directions",
    );
    s.ignores(
        "coat_affect_color",
        0.0,
        "the coat leaves the colour below it",
    );
    s.ignores(
        "coat_affect_roughness",
        0.0,
        "the coat leaves the roughness below it",
    );
    s.warn_of_coat_normal("coat_normal");
}
