//! A document to what a look has: each of its materials, by the model of its surface.

use std::collections::HashSet;

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
    let mut chosen: Vec<ElementId> = match &wanted.material {
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
    warn_of_version(&mut converter);
    leave_unknown(&mut converter, &mut chosen, wanted);
    let mut seen = HashSet::new();
    for id in chosen {
        let own = document.element(id).name();
        let name = wanted.name.as_deref().unwrap_or(own).to_owned();
        if name.is_empty() {
            converter.warn(id, "this material has no name: it is left out");
            continue;
        }
        if !seen.insert(name.clone()) {
            let message =
                format!("there is another material called `{name}`: this one is left out");
            converter.warn(id, message);
            continue;
        }
        if let Some(parameters) = shader::convert(&mut converter, id) {
            converter.out.materials.push(Material { name, parameters });
        }
    }
    Ok(converter.out)
}

/// Documents of versions before 1.38 have nodes and inputs that were called otherwise.
fn warn_of_version(converter: &mut Converter<'_>) {
    let root = converter.document.element(Document::ROOT);
    let version = root.attribute("version").unwrap_or("");
    let minor = version
        .strip_prefix("1.")
        .and_then(|minor| minor.parse::<u32>().ok());
    if minor.is_some_and(|minor| minor < 38) {
        let message = format!(
            "the document is of version {version}, and read as one of 1.38: MaterialX's own tools write it anew as 1.39"
        );
        converter.warn(Document::ROOT, message);
    }
}

/// Leaves out materials that are of no use, with one warning. Where none is of use the mistake is another one.
fn leave_unknown(converter: &mut Converter<'_>, chosen: &mut Vec<ElementId>, wanted: &Wanted) {
    /// More of them aren't named.
    const MAX_NAMES: usize = 8;
    let Some(known) = &wanted.known else { return };
    let document = converter.document;
    let name = |id| document.element(id).name();
    if wanted.name.is_some() || !chosen.iter().any(|&id| known.contains(name(id))) {
        return;
    }
    let unknown: Vec<&str> = (chosen.iter())
        .map(|&id| name(id))
        .filter(|name| !name.is_empty() && !known.contains(*name))
        .collect();
    if !unknown.is_empty() {
        let more = if unknown.len() > MAX_NAMES {
            ", ..."
        } else {
            ""
        };
        let names = unknown[..unknown.len().min(MAX_NAMES)].join(", ");
        let message = format!("materials that the scene hasn't are left out: {names}{more}");
        converter.warn(Document::ROOT, message);
    }
    chosen.retain(|&id| known.contains(name(id)));
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
