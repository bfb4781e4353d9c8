//! Surface shaders to the keys of a look's material: a file for each model. What a model has and the look hasn't is named.

mod gltf_pbr;
mod open_pbr;
mod standard_surface;
mod surface;
mod usd_preview;

use std::collections::HashSet;
use std::rc::Rc;

use scene::look;

use crate::convert::{Converter, Scope};
use crate::document::{Document, ElementId};

use surface::Surface;

/// Turns the inputs of a shader into keys of a material.
type Model = fn(&mut Surface<'_, '_>);

/// The models: their categories, and what each has.
const MODELS: [(&str, &[&str], Model); 4] = [
    (
        "standard_surface",
        standard_surface::INPUTS,
        standard_surface::convert,
    ),
    ("open_pbr_surface", open_pbr::INPUTS, open_pbr::convert),
    ("gltf_pbr", gltf_pbr::INPUTS, gltf_pbr::convert),
    (
        "UsdPreviewSurface",
        usd_preview::INPUTS,
        usd_preview::convert,
    ),
];

fn is_shader(document: &Document, id: ElementId) -> bool {
    let element = document.element(id);
    element.attribute("type") == Some("surfaceshader")
        && element.kind != "input"
        && element.kind != "output"
}

/// What may become a material: the `surfacematerial` nodes, and surface shaders that none of them uses and no other shader inherits
/// from.
pub(crate) fn materials(document: &Document) -> Vec<ElementId> {
    let top = document.children(Document::ROOT).iter().copied();
    let mut used = HashSet::new();
    for material in (top.clone()).filter(|&id| document.element(id).kind == "surfacematerial") {
        if let Some(input) = document.input(material, "surfaceshader")
            && let Some(name) = document.element(input).attribute("nodename")
            && let Some(shader) = document.named(Document::ROOT, input, name)
        {
            // Those that it inherits from are seen in it.
            used.extend(document.lineage(shader));
        }
    }
    for shader in (top.clone()).filter(|&id| is_shader(document, id)) {
        let bases: Vec<ElementId> = document.lineage(shader).skip(1).collect();
        // Of those that inherit from each other in a circle none is the base.
        if !bases.contains(&shader) {
            used.extend(bases);
        }
    }
    let is_wanted = |&id: &ElementId| {
        let element = document.element(id);
        element.kind == "surfacematerial" || (is_shader(document, id) && !used.contains(&id))
    };
    let mut found: Vec<ElementId> = top.filter(is_wanted).collect();
    // Of several of one name the first holds: not one of a namespace, whose name is longer elsewhere.
    found.sort_by_key(|&id| document.space(id) != document.space(Document::ROOT));
    found
}

/// Keys of a material; `None` where its shader is of no known model, which is warned of.
pub(crate) fn convert(
    converter: &mut Converter<'_>,
    id: ElementId,
) -> Option<Vec<(&'static str, look::Value)>> {
    let document = converter.document;
    let root = Scope::root();
    let name = document.element(id).name();
    let (scope, shader) = match document.input(id, "surfaceshader") {
        Some(input) => match converter.source(&root, input) {
            Some(found) => found,
            None => {
                converter.warn(
                    input,
                    format!("the material `{name}` has no shader: it is left out"),
                );
                return None;
            }
        },
        None if document.element(id).kind == "surfacematerial" => {
            converter.warn(
                id,
                format!("the material `{name}` has no shader: it is left out"),
            );
            return None;
        }
        None => (Rc::clone(&root), id),
    };
    let kind = &document.element(shader).kind;
    let Some((_, inputs, model)) = MODELS.iter().find(|(model, ..)| model == kind) else {
        let known: Vec<&str> = MODELS.iter().map(|(model, ..)| *model).collect();
        let known = known.join(", ");
        let message = format!(
            "surfaces of the model `{kind}` can't be shown ({known} can): `{name}` is left out"
        );
        converter.warn(shader, message);
        return None;
    };
    let mut surface = Surface::new(converter, scope, shader, name);
    model(&mut surface);
    surface.name_strangers(inputs);
    if let Some(input) = document.input(id, "displacementshader") {
        surface.displacement(&root, input);
    }
    Some(surface.finish())
}
