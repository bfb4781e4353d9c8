//! `[[materialx]]` of a look: what its documents give, as if it were written in the look.

use std::borrow::Cow;
use std::collections::HashSet;

use materialx::{Document, Wanted};
use texgen::{Diagnostic, Diagnostics};

use crate::input::Files;
use crate::scene::Material;
use crate::scene::look::{Field, Look, MaterialxLook, Section, Span, Spanned, Table, Value, table};

/// The look with the nodes and materials of its documents, and what can't be expressed of these. What the look says of a node or a
/// material of the same name itself holds. Where the materials of the scene are given, documents without a `material` or `name`
/// of their own give those that the scene or a blend of the look has.
///
/// # Errors
/// A document that can't be read, with the line of the look or its own.
pub(crate) fn expanded<'l>(
    look: &'l Look,
    files: &dyn Files,
    scene: Option<&[Material]>,
) -> Result<(Cow<'l, Look>, Diagnostics), Diagnostics> {
    let mut warnings = Diagnostics::new();
    if look.materialx.is_empty() {
        return Ok((Cow::Borrowed(look), warnings));
    }
    let known = scene.map(|materials| known_names(look, materials));
    let mut whole = look.clone();
    let mut problems = Diagnostics::new();
    let mut given = Given::default();
    for document in std::mem::take(&mut whole.materialx) {
        match add(&mut whole, &document, &mut given, known.as_ref(), files) {
            Ok(found) => warnings.append(found),
            Err(found) => problems.append(found),
        }
    }
    match problems.has_errors() {
        true => Err(problems),
        false => Ok((Cow::Owned(whole), warnings)),
    }
}

/// Materials that there are, and those that blends need.
fn known_names(look: &Look, scene: &[Material]) -> HashSet<String> {
    let blends = (look.materials.iter()).filter_map(|material| material.blend.as_ref());
    let blended = blends.flat_map(|blend| [&blend.value.base.value, &blend.value.over.value]);
    let scene = scene.iter().map(|material| &material.name);
    scene.chain(blended).cloned().collect()
}

/// Names of what documents have given so far.
#[derive(Default)]
struct Given {
    nodes: HashSet<String>,
    materials: HashSet<String>,
}

fn add(
    look: &mut Look,
    wanted: &MaterialxLook,
    given: &mut Given,
    known: Option<&HashSet<String>>,
    files: &dyn Files,
) -> Result<Diagnostics, Diagnostics> {
    let path = look.resolve(&wanted.file.value);
    if !files.has(&path) {
        let message = format!("there is no file {}", path.display());
        let problem = Diagnostic::error(message);
        let span = wanted.file.span.clone();
        let note = "paths are relative to the look file";
        return Err(problem
            .with_label(&look.file, span, "")
            .with_note(note)
            .into());
    }
    let text = |spanned: &Option<Spanned<String>>| spanned.as_ref().map(|s| s.value.clone());
    let options = Wanted {
        material: text(&wanted.material),
        name: text(&wanted.name),
        folder: look.resolve(""),
        // What the look itself calls so is meant to stand for a document's node; what another document does, is not.
        taken: given.nodes.clone(),
        known: known.filter(|_| wanted.material.is_none()).cloned(),
    };
    let document = Document::open(files, &path, wanted.drafts)?;
    let converted = materialx::convert(&document, files, &options)?;
    let span = &wanted.file.span;
    let mut warnings = converted.warnings;
    for node in converted.nodes {
        given.nodes.insert(node.name.clone());
        if look.nodes.iter().any(|known| known.name.value == node.name) {
            continue;
        }
        let texture = ("texture".to_owned(), Value::Text(node.texture));
        let fields = fields(std::iter::once(texture).chain(node.arguments), span);
        if let Table::Node(node) = table(&look.file, &Section::Node(node.name), &fields, span)? {
            look.nodes.push(node);
        }
    }
    for material in converted.materials {
        let name = material.name;
        if !given.materials.insert(name.clone()) {
            let message = format!("another document gives `{name}` already, and that one holds");
            let warning = Diagnostic::warning(message).with_label(&look.file, span.clone(), "");
            warnings.push(warning.with_note("`name` calls a material of a document otherwise"));
            continue;
        }
        let parameters = material.parameters.into_iter();
        let fields = fields(parameters.map(|(key, value)| (key.to_owned(), value)), span);
        let section = Section::Material(name.clone());
        let Table::Material(read) = table(&look.file, &section, &fields, span)? else {
            continue;
        };
        match look
            .materials
            .iter_mut()
            .find(|known| known.name.value == name)
        {
            Some(own) => own.stand_over(*read),
            None => look.materials.push(*read),
        }
    }
    Ok(warnings)
}

/// Keys and values, all of which stand at one place of the look.
fn fields(values: impl Iterator<Item = (String, Value)>, span: &Span) -> Vec<Field> {
    let field = |(key, mut value): (String, Value)| {
        place(&mut value, span);
        Field {
            key: Spanned::new(key, span.clone()),
            value: Spanned::new(value, span.clone()),
        }
    };
    values.map(field).collect()
}

fn place(value: &mut Value, span: &Span) {
    match value {
        Value::List(items) => {
            for item in items {
                item.span = span.clone();
                place(&mut item.value, span);
            }
        }
        Value::Table(fields) => {
            for field in fields {
                field.key.span = span.clone();
                field.value.span = span.clone();
                place(&mut field.value.value, span);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::input::Disk;
    use crate::scene::look::Input;

    const DOCUMENT: &str = r#"<materialx version="1.39">
        <noise3d name="noise" type="float"><input name="amplitude" type="float" value="0.5"/></noise3d>
        <standard_surface name="s" type="surfaceshader">
          <input name="specular_roughness" type="float" nodename="noise"/>
          <input name="metalness" type="float" value="1"/>
          <input name="diffuse_roughness" type="float" value="0.5"/>
          <input name="coat" type="float" value="1"/>
        </standard_surface>
        <surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>
        </materialx>"#;

    #[test]
    fn a_look_has_what_its_documents_give() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("a.mtlx"), DOCUMENT).expect("a file");
        let path = folder.path().join("a.look.toml");
        let read =
            |text: &str| Look::parse(&path, text).unwrap_or_else(|p| panic!("{}", p.render()));
        let look = read(
            "[[materialx]]\nfile = 'a.mtlx'\nname = 'Steel'\n[material.Steel]\nmetallic = 0.25\n",
        );
        let (whole, warnings) =
            expanded(&look, &Disk, None).unwrap_or_else(|p| panic!("{}", p.render()));
        assert!(
            warnings.render().contains("diffuse_roughness"),
            "{}",
            warnings.render()
        );
        assert_eq!(whole.nodes[0].name.value, "noise");
        assert_eq!(whole.nodes[0].texture.value, "mx_noise3d_float");
        let [steel] = &whole.materials[..] else {
            panic!("{:?}", whole.materials);
        };
        assert_eq!(steel.constant("metallic").map(|m| m.x), Some(0.25));
        assert!(steel.is_driven("roughness"));
        // Mistakes have the look's line.
        let look = read("[[materialx]]\nfile = 'b.mtlx'\n");
        let error = expanded(&look, &Disk, None)
            .expect_err("it isn't there")
            .render();
        assert!(
            error.contains("no file") && error.contains("a.look.toml:2"),
            "{error}"
        );
        // A second document's nodes are its own, whatever they are called.
        let other = DOCUMENT
            .replace("0.5\"/></noise3d>", "0.125\"/></noise3d>")
            .replace("name=\"M\"", "name=\"N\"");
        std::fs::write(folder.path().join("c.mtlx"), other).expect("a file");
        let both = "[[materialx]]\nfile = 'a.mtlx'\n[[materialx]]\nfile = 'c.mtlx'\n";
        let look = read(both);
        let (whole, _) = expanded(&look, &Disk, None).unwrap_or_else(|p| panic!("{}", p.render()));
        let nodes: Vec<&str> = whole.nodes.iter().map(|n| n.name.value.as_str()).collect();
        assert_eq!(nodes.len(), 2, "{nodes:?}");
        let links: HashSet<String> = (whole.materials.iter())
            .flat_map(|material| material.inputs())
            .filter_map(|input| match &input.value {
                Input::Link(link) => Some(link.node.clone()),
                _ => None,
            })
            .collect();
        assert_eq!(links, nodes.iter().map(|&n| n.to_owned()).collect());
        let twice = "[[materialx]]\nfile = 'a.mtlx'\n[[materialx]]\nfile = 'a.mtlx'\n";
        let look = read(twice);
        let (whole, warnings) =
            expanded(&look, &Disk, None).unwrap_or_else(|p| panic!("{}", p.render()));
        assert_eq!(whole.materials.len(), 1);
        assert!(warnings.render().contains("another document gives `M`"));
        // Of many materials those are given that the scene has, or a blend; of none the mistake is said where all is built.
        let of = |name: &str| Material {
            name: name.to_owned(),
            ..Material::default()
        };
        let text = "[[materialx]]\nfile = 'a.mtlx'\n[[materialx]]\nfile = 'd.mtlx'\n";
        let more = DOCUMENT.replace(
            "</materialx>",
            r#"<surfacematerial name="Other" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial></materialx>"#,
        );
        std::fs::write(folder.path().join("d.mtlx"), more.replace("\"M\"", "\"N\""))
            .expect("a file");
        let look = read(text);
        let names = |scene: &[Material]| {
            let given = expanded(&look, &Disk, Some(scene));
            let (whole, warnings) = given.unwrap_or_else(|p| panic!("{}", p.render()));
            let materials = whole.materials.iter();
            let names: Vec<String> = materials.map(|m| m.name.value.clone()).collect();
            (names, warnings.render())
        };
        let (given, said) = names(&[of("M"), of("N")]);
        assert_eq!(given, ["M", "N"]);
        assert!(
            said.contains("the scene hasn't are left out: Other"),
            "{said}"
        );
        let (given, said) = names(&[of("M")]);
        assert_eq!(given, ["M", "N", "Other"], "{said}");
        let nothing = read("");
        let (same, _) = expanded(&nothing, &Disk, None).expect("nothing to read");
        assert_eq!(same.path, Path::new(&path));
    }
}
