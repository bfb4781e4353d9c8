//! A document to what a look has: each of its materials, by the model of its surface.

use scene::input::Files;
use texgen::{Diagnostics, did_you_mean};

use crate::convert::{Converted, Converter, Material, Wanted};
use crate::document::{Document, ElementId};
use crate::shader;

/// Turns a document into nodes and materials.
///
/// # Errors
/// It has no material, or none of the wanted name.
pub fn convert(
    document: &Document,
    files: &dyn Files,
    wanted: &Wanted,
) -> Result<Converted, Diagnostics> {
    let mut converter = Converter::new(document, files, wanted);
    let found = shader::materials(document);
    let names: Vec<&str> = found
        .iter()
        .map(|&id| document.element(id).name())
        .collect();
    let chosen: Vec<ElementId> = match &wanted.material {
        None => found.clone(),
        Some(name) => (found.iter().copied())
            .filter(|&id| document.element(id).name() == name)
            .collect(),
    };
    if chosen.is_empty() {
        return Err(none_found(document, wanted, &names).into());
    }
    if let (Some(name), true) = (&wanted.name, chosen.len() > 1) {
        let message = format!(
            "there are {} materials, and one name, `{name}`",
            chosen.len()
        );
        let problem = document.error(chosen[1], message);
        let note = format!("choose one of them: {}", names.join(", "));
        return Err(problem.with_note(note).into());
    }
    for id in chosen {
        let name = wanted.name.as_deref();
        let name = name.unwrap_or(document.element(id).name()).to_owned();
        if let Some(parameters) = shader::convert(&mut converter, id) {
            converter.out.materials.push(Material { name, parameters });
        }
    }
    Ok(converter.out)
}

fn none_found(document: &Document, wanted: &Wanted, names: &[&str]) -> texgen::Diagnostic {
    let Some(name) = &wanted.material else {
        let problem = document.error(Document::ROOT, "the document has no material");
        return problem.with_note(
            "what is read: `surfacematerial` nodes, and surface shaders (standard_surface, open_pbr_surface, gltf_pbr, \
             UsdPreviewSurface)",
        );
    };
    let problem = document.error(
        Document::ROOT,
        format!("the document has no material called `{name}`"),
    );
    problem.with_note(match did_you_mean(name, names.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("it has {}", names.join(", ")),
    })
}
