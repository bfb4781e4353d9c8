//! OpenPBR Surface 1.1.

use crate::value::Value;

use super::surface::Surface;

/// What the model has.
pub(super) const INPUTS: &[&str] = &[
    "base_weight",
    "base_color",
    "base_diffuse_roughness",
    "base_metalness",
    "specular_weight",
    "specular_color",
    "specular_roughness",
    "specular_ior",
    "specular_roughness_anisotropy",
    "transmission_weight",
    "transmission_color",
    "transmission_depth",
    "transmission_scatter",
    "transmission_scatter_anisotropy",
    "transmission_dispersion_scale",
    "transmission_dispersion_abbe_number",
    "subsurface_weight",
    "subsurface_color",
    "subsurface_radius",
    "subsurface_radius_scale",
    "subsurface_scatter_anisotropy",
    "fuzz_weight",
    "fuzz_color",
    "fuzz_roughness",
    "coat_weight",
    "coat_color",
    "coat_roughness",
    "coat_roughness_anisotropy",
    "coat_ior",
    "coat_darkening",
    "thin_film_weight",
    "thin_film_thickness",
    "thin_film_ior",
    "emission_luminance",
    "emission_color",
    "geometry_opacity",
    "geometry_thin_walled",
    "geometry_normal",
    "geometry_coat_normal",
    "geometry_tangent",
    "geometry_coat_tangent",
];

pub(super) fn convert(s: &mut Surface<'_, '_>) {
    let (base, color) = (s.number("base_weight", 1.0), s.color("base_color", 0.8));
    let mut body = s.product("base", &color, &base);
    let subsurface = s.number("subsurface_weight", 0.0);
    let is_thin = s.is_on("geometry_thin_walled");
    if !subsurface.is(0.0) {
        let color = s.color("subsurface_color", 0.8);
        let (through, back) = match is_thin {
            true => thin_walled(s, &subsurface),
            false => (Value::number(0.0), subsurface),
        };
        body = s.mixed("subsurface", &body, &color, &back);
        if is_thin {
            s.set("diffuse_transmission", &through, 0.0, 1.0);
            s.set_color("diffuse_transmission_color", &color, 1.0);
        } else {
            s.warn(
                "subsurface_weight",
                "subsurface scattering is shown as a diffuse surface of its colour",
            );
        }
    }
    let (weight, color) = (
        s.number("transmission_weight", 0.0),
        s.color("transmission_color", 1.0),
    );
    let depth = s.number("transmission_depth", 0.0);
    let body = s.transmission(&weight, &color, &depth, is_thin, body);
    let (coat, coat_color) = (s.number("coat_weight", 0.0), s.color("coat_color", 1.0));
    let body = s.below_coat("coated_base", &body, &coat, &coat_color);
    s.set_color("base_color", &body, 1.0);
    let metalness = s.number("base_metalness", 0.0);
    s.set("metallic", &metalness, 0.0, 1.0);
    let roughness = s.number("specular_roughness", 0.3);
    let roughness = roughness_below_coat(s, roughness, &coat);
    let anisotropy = s.number("specular_roughness_anisotropy", 0.0);
    s.roughness(&roughness, &anisotropy, widths);
    let specular = s.number("specular_weight", 1.0);
    s.set("specular", &specular, 0.0, 1.0);
    let color = s.color("specular_color", 1.0);
    let color = s.below_coat("coated_specular", &color, &coat, &coat_color);
    s.set_color("specular_color", &color, f32::MAX);
    let ior = s.number("specular_ior", 1.5);
    let film = s.number("thin_film_weight", 0.0);
    // Films lie in air here, and bodies that let light through are seen from inside, too.
    let ior = match weight.is(0.0) && film.is(0.0) {
        true => ior_below_coat(s, &ior, &coat),
        false => ior,
    };
    s.set("ior", &ior, 1.0, f32::MAX);
    if !anisotropy.is(0.0) {
        s.ignores_link(
            "geometry_tangent",
            "reflections stretch along the texture coordinates",
        );
    }
    dispersion(s);
    if !coat.is(0.0) {
        s.set("coat", &coat, 0.0, 1.0);
        let roughness = s.number("coat_roughness", 0.0);
        s.set("coat_roughness", &roughness, 0.0, 1.0);
        s.ignores("coat_ior", 1.5, "the coat's index of refraction is 1.5");
        s.ignores(
            "coat_roughness_anisotropy",
            0.0,
            "the coat reflects alike in all directions",
        );
        s.ignores("coat_darkening", 0.0, "the coat leaves the colour below it");
        s.warn_of_coat_normal("geometry_coat_normal");
    }
    let (fuzz, color) = (s.number("fuzz_weight", 0.0), s.color("fuzz_color", 1.0));
    if !fuzz.is(0.0) {
        let color = s.product("fuzz", &color, &fuzz);
        s.set_color("sheen_color", &color, 1.0);
        let roughness = s.number("fuzz_roughness", 0.5);
        s.set("sheen_roughness", &roughness, 0.0, 1.0);
    }
    if !film.is(0.0) {
        s.set("iridescence", &film, 0.0, 1.0);
        let micrometres = s.number("thin_film_thickness", 0.5);
        let nanometres = s.product("film", &micrometres, &Value::number(1000.0));
        s.set("iridescence_thickness", &nanometres, 0.0, f32::MAX);
        let ior = s.number("thin_film_ior", 1.4);
        s.set("iridescence_ior", &ior, 1.0, f32::MAX);
    }
    let (luminance, color) = (
        s.number("emission_luminance", 0.0),
        s.color("emission_color", 1.0),
    );
    s.emission(&luminance, &color);
    let opacity = s.number("geometry_opacity", 1.0);
    s.opacity(&opacity);
    s.normal("geometry_normal");
    if is_thin {
        s.thin_wall();
    }
    s.ignores(
        "base_diffuse_roughness",
        0.0,
        "diffuse surfaces are Lambertian",
    );
    s.ignores("transmission_scatter", 0.0, "bodies don't scatter");
}

/// Of the subsurface scattering of a thin wall, whose weight is given: the share of diffuse light that goes through, and which part
/// of the rest comes back with the same colour instead of the base's. Light goes to both sides alike, or more forwards (OpenPBR
/// 1.1, "Thin-walled case").
fn thin_walled(s: &mut Surface<'_, '_>, weight: &Value) -> (Value, Value) {
    let forwards = s.number("subsurface_scatter_anisotropy", 0.0);
    let (Some([w, ..]), Some([g, ..])) = (weight.known(), forwards.known()) else {
        for input in ["subsurface_weight", "subsurface_scatter_anisotropy"] {
            s.ignores_node(input, "all of the scattered light goes through");
        }
        return (weight.clone(), Value::number(0.0));
    };
    let (w, g) = (w.clamp(0.0, 1.0), g.clamp(-1.0, 1.0));
    let through = w * (1.0 + g) / 2.0;
    let back = w * (1.0 - g) / 2.0 / (1.0 - through).max(1e-6);
    (Value::number(through), Value::number(back.min(1.0)))
}

/// The roughness of what lies below a coat, which is seen through it twice (OpenPBR 1.1, "Coat"), where all of it is known.
fn roughness_below_coat(s: &mut Surface<'_, '_>, roughness: Value, coat: &Value) -> Value {
    let of_coat = s.number("coat_roughness", 0.0);
    if coat.is(0.0) || of_coat.is(0.0) {
        return roughness;
    }
    let (Some([r, ..]), Some([of_coat, ..]), Some([coat, ..])) =
        (roughness.known(), of_coat.known(), coat.known())
    else {
        s.warn(
            "coat_roughness",
            "a rough coat leaves the roughness below it where a node drives it or one of both",
        );
        return roughness;
    };
    let both = (r.powi(4) + 2.0 * of_coat.powi(4)).powf(0.25).min(1.0);
    Value::number(r + (both - r) * coat.clamp(0.0, 1.0))
}

/// The index of an opaque body relative to the coat on it, where both are known.
fn ior_below_coat(s: &mut Surface<'_, '_>, ior: &Value, coat: &Value) -> Value {
    let coat_ior = s.number("coat_ior", 1.6).known();
    let (Some([ior, ..]), Some([coat_ior, ..]), Some([coat, ..])) =
        (ior.known(), coat_ior, coat.known())
    else {
        return ior.clone();
    };
    let ratio = ior / (1.0 + (coat_ior - 1.0) * coat.clamp(0.0, 1.0)).max(1.0);
    Value::number(ratio.max(1.0 / ratio.max(1e-6)))
}

/// Widths of reflections along the tangent and across it: MaterialX's `open_pbr_anisotropy`, which keeps their mean square.
fn widths(roughness: f32, anisotropy: f32) -> [f32; 2] {
    let ratio = 1.0 - anisotropy;
    let along = roughness * roughness * (2.0 / (1.0 + ratio * ratio)).sqrt();
    [along, along * ratio]
}

fn dispersion(s: &mut Surface<'_, '_>) {
    s.ignores_node(
        "transmission_dispersion_scale",
        "all colours are refracted alike",
    );
    let scale = s.number("transmission_dispersion_scale", 0.0).known();
    let Some([scale, ..]) = scale.filter(|scale| scale[0] > 0.0) else {
        return;
    };
    s.ignores_node("transmission_dispersion_abbe_number", "20 stands for it");
    let abbe = s.number("transmission_dispersion_abbe_number", 20.0);
    let [abbe, ..] = abbe.known().unwrap_or([20.0; 4]);
    if abbe > 0.0 {
        let dispersion = Value::number(20.0 * scale / abbe);
        s.set("dispersion", &dispersion, 0.0, f32::MAX);
    }
}
