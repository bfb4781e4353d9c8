//! Frames of the graph: how an editor shows nodes together. No picture depends on them.

use glam::Vec3;

use super::reader::Reader;
use super::value::{Field, Span, Spanned, Value};

/// `[graph.NAME]`: a frame around the cards of some nodes and materials, where the look is shown as a graph.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameLook {
    /// Its title.
    pub name: Spanned<String>,
    /// The nodes that it is around. One that the look lacks means nothing.
    pub nodes: Vec<Spanned<String>>,
    /// The materials that it is around, likewise.
    pub materials: Vec<Spanned<String>>,
    /// Linear; that of the editor where absent.
    pub color: Option<Spanned<Vec3>>,
}

pub(super) fn frame(
    reader: &mut Reader,
    name: &Spanned<String>,
    table: &[Field],
    _span: &Span,
) -> Option<FrameLook> {
    const KEYS: [&str; 3] = ["nodes", "materials", "color"];
    if name.value.trim().is_empty() {
        reader.problem(&name.span, "a frame of the graph needs a title");
    }
    let (mut nodes, mut materials, mut color) = (Vec::new(), Vec::new(), None);
    for Field { key, value } in table {
        match key.value.as_str() {
            "nodes" => nodes = names(reader, value, "a list of node names"),
            "materials" => materials = names(reader, value, "a list of material names"),
            "color" => color = reader.color(value),
            _ => reader.unknown_key(key, "[graph.NAME]", &KEYS),
        }
    }
    Some(FrameLook {
        name: name.clone(),
        nodes,
        materials,
        color,
    })
}

fn names(reader: &mut Reader, value: &Spanned<Value>, what: &str) -> Vec<Spanned<String>> {
    match &value.value {
        Value::List(names) => names.iter().filter_map(|name| reader.text(name)).collect(),
        _ => {
            reader.wrong_kind(value, what);
            Vec::new()
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::look::{Look, LookDocument, Section, Value};

    const LOOK: &str = "[node.a]\ntexture = 't'\n\n# Old paint.\n[graph.'Rust, old'] # mine\nnodes = ['a', 'gone']\nmaterials = ['Iron']\ncolor = '#ff0000'\n[graph.b]\n";

    #[test]
    fn frames_are_read_and_kept() {
        let path = Path::new("a.look.toml");
        let look = Look::parse(path, LOOK).unwrap_or_else(|e| panic!("{e}"));
        let [frame, bare] = &look.frames[..] else {
            panic!("{:?}", look.frames);
        };
        assert_eq!(frame.name.value, "Rust, old");
        let nodes: Vec<&str> = frame.nodes.iter().map(|node| &*node.value).collect();
        assert_eq!(nodes, ["a", "gone"]);
        assert_eq!(frame.materials[0].value, "Iron");
        let color = frame.color.as_ref().expect("it has one").value;
        assert_eq!(color.to_array(), [1.0, 0.0, 0.0]);
        assert!(bare.nodes.is_empty() && bare.materials.is_empty() && bare.color.is_none());

        let mut document = LookDocument::parse(path, LOOK).expect("TOML");
        let section = Section::Frame("Rust, old".to_owned());
        document.rename(&section, "Rust").expect("renamed");
        assert_eq!(document.text(), LOOK.replace("'Rust, old'", "Rust"));
        let section = Section::Frame("Rust".to_owned());
        let color = Value::Text("#00ff00".to_owned());
        document.set(&section, "color", &color).expect("set");
        assert!(document.text().contains("# mine"), "{}", document.text());
    }

    #[test]
    fn mistakes_are_pointed_out() {
        for (text, expected) in [
            ("[graph.a]\nnodes = 'b'", "a list of node names"),
            ("[graph.a]\nnodes = [1]", "a string"),
            ("[graph.a]\nmaterials = 'b'", "a list of material names"),
            ("[graph.a]\ncolour = 'red'", "did you mean `color`?"),
            ("[graph.' ']\nnodes = []", "needs a title"),
            ("[graph]\nnodes = []", "[graph.NAME]"),
        ] {
            let problems = Look::parse(Path::new("a"), text).expect_err(text);
            let said = problems.to_string();
            assert!(said.contains(expected), "{text}: {said}");
        }
    }
}
