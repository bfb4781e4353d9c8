//! UsdPreviewSurface of Universal Scene Description.

use crate::value::Value;

use super::surface::Surface;

/// What the model has.
pub(super) const INPUTS: &[&str] = &[
    "diffuseColor",
    "emissiveColor",
    "useSpecularWorkflow",
    "specularColor",
    "metallic",
    "roughness",
    "clearcoat",
    "clearcoatRoughness",
    "opacity",
    "opacityMode",
    "opacityThreshold",
    "ior",
    "normal",
    "displacement",
    "occlusion",
];

pub(super) fn convert(s: &mut Surface<'_, '_>) {
    let color = s.color("diffuseColor", 0.18);
    s.set_color("base_color", &color, 1.0);
    let ior = s.number("ior", 1.5);
    if s.is_on("useSpecularWorkflow") {
        // What is reflected at normal incidence; the look's is a factor on what the index gives.
        let known = ior.known().map_or(1.5, |ior| ior[0]);
        let index = if known > 1.0 { known } else { 1.5 };
        let factor = ((index + 1.0) / (index - 1.0)).powi(2);
        let color = s.color("specularColor", 0.0);
        let color = s.product("specular", &color, &Value::number(factor.min(1e6)));
        s.set("metallic", &Value::number(0.0), 0.0, 1.0);
        s.set_color("specular_color", &color, f32::MAX);
        s.set("ior", &Value::number(index), 1.0, f32::MAX);
        s.ignores_node("ior", "it is 1.5");
    } else {
        let metallic = s.number("metallic", 0.0);
        s.set("metallic", &metallic, 0.0, 1.0);
        s.set("ior", &ior, 1.0, f32::MAX);
    }
    let roughness = s.number("roughness", 0.5);
    s.set("roughness", &roughness, 0.0, 1.0);
    let coat = s.number("clearcoat", 0.0);
    if !coat.is(0.0) {
        s.set("coat", &coat, 0.0, 1.0);
        let roughness = s.number("clearcoatRoughness", 0.01);
        s.set("coat_roughness", &roughness, 0.0, 1.0);
    }
    let color = s.color("emissiveColor", 0.0);
    s.emission(&Value::number(1.0), &color);
    let opacity = s.number("opacity", 1.0);
    let threshold = s.number("opacityThreshold", 0.0);
    match threshold.is(0.0) {
        true => s.opacity(&opacity),
        false => s.cut(&opacity, &threshold),
    }
    s.tangent_space_normal("normal");
    s.ignores("displacement", 0.0, "the surface stays where it is");
}
