//! The graph of a look on its own, without scene, images or programs: what an editor shows, and asks whether a link fits.

use std::sync::Arc;

use texgen::{Graph, Library, NodeId};

use crate::scene::look::{Look, NodeLook, find};

use super::values::{Argument, argument};
use super::wiring::check_driver;
use super::{NodeOutput, Output};

/// The nodes of a look with their constants and links. What doesn't fit is left out, as if it weren't written: nodes of
/// textures that the library lacks, values of another type. Images have no value in it.
pub fn sketch(look: &Look, library: &Arc<Library>) -> Graph {
    let mut graph = Graph::new(Arc::clone(library));
    // Texture and name are all that can be wrong with a node, and then there is none.
    let nodes: Vec<_> = (look.nodes.iter())
        .filter_map(|table| {
            let added = graph.add_node(&table.name.value, &table.texture.value, [0, 0]);
            Some((table, added.ok()?))
        })
        .collect();
    for (table, node) in nodes {
        for field in &table.params {
            let name = &field.key.value;
            let Some((_, parameter)) = graph.texture(node).parameter(name) else {
                continue;
            };
            // The rest is an image, or reported by whoever renders the look.
            let _ = match argument(&field.value, parameter.ty) {
                Ok(Argument::Constant(value)) => graph.set_value(node, name, value),
                Ok(Argument::Link(link)) => match graph.node(&link.node) {
                    Some(source) => graph.set_link(node, name, source, link.swizzle),
                    None => continue,
                },
                Ok(Argument::Image(_)) | Err(_) => continue,
            };
        }
    }
    graph
}

/// Brings the sketch of a look to what the look has become; false, and the sketch is no longer of any look, where nodes or
/// links have changed. Constants alone take no search for circles, which is most of [`sketch`]'s time.
pub fn resketch(graph: &mut Graph, look: &Look) -> bool {
    let library = Arc::clone(graph.library());
    let has_texture = |table: &&NodeLook| library.get(&table.texture.value).is_some();
    let tables: Vec<&NodeLook> = look.nodes.iter().filter(has_texture).collect();
    let nodes = graph.ids();
    tables.len() == nodes.len()
        && (tables.into_iter().zip(nodes)).all(|(table, node)| resketch_node(graph, table, node))
}

fn resketch_node(graph: &mut Graph, table: &NodeLook, node: NodeId) -> bool {
    let texture = graph.texture(node);
    if graph.name(node) != table.name.value || texture.name() != table.texture.value {
        return false;
    }
    let mut constants = Vec::new();
    for parameter in texture.parameters() {
        let name = &parameter.name;
        let written = find(&table.params, name).map(|value| argument(value, parameter.ty));
        let known = graph.value(node, name);
        match (written, graph.link(node, name)) {
            (Some(Ok(Argument::Link(wanted))), Some(link))
                if graph.name(link.source) == wanted.node && link.swizzle == wanted.swizzle => {}
            (Some(Ok(Argument::Link(_))), _) | (_, Some(_)) => return false,
            (Some(Ok(Argument::Constant(value))), None)
                if known != Some(&value) || graph.attribute(node, name).is_some() =>
            {
                constants.push((name.clone(), Some(value)));
            }
            (Some(Ok(Argument::Constant(_))), None) => {}
            // Where an attribute would hold, even the default is a constant of its own.
            _ if known != parameter.default.as_ref()
                || (parameter.attribute.is_some() && graph.attribute(node, name).is_none()) =>
            {
                constants.push((name.clone(), None));
            }
            _ => {}
        }
    }
    for (name, value) in constants {
        // What doesn't fit is left out, and leaves the default.
        let is_set = value.is_some_and(|value| graph.set_value(node, &name, value).is_ok());
        if !is_set {
            let _ = graph.reset(node, &name);
        }
    }
    true
}

impl Output {
    /// Checks that a link of `graph` can drive this.
    ///
    /// # Errors
    /// Says what to do instead.
    pub fn check(self, graph: &Graph, link: texgen::Link) -> Result<(), String> {
        let texgen::Link { source, swizzle } = link;
        let source = NodeOutput {
            node: source,
            swizzle,
        };
        check_driver(graph, source, self.kind())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use texgen::{SourceFile, TextureType, Value};

    use super::*;

    #[test]
    fn what_fits_is_there() {
        let texture = "fn userProc(x: f32, c: vec3f) -> vec3f { return c * x; }";
        let texture = TextureType::parse(SourceFile::new("t", "t.wgsl", texture));
        let texture = texture.unwrap_or_else(|e| panic!("{e}"));
        let library = Arc::new(Library::new(vec![texture]).expect("one texture"));
        let text = "[node.a]\ntexture = 't'\nx = 2\nc = 'b'\n[node.b]\ntexture = 't'\nx = 'a.y'\nno = 1\n\
                    [node.c]\ntexture = 'u'\n[node.d]\ntexture = 't'\nx = 'a'\nc = '#fff'";
        let look = Look::parse(Path::new("l.toml"), text).unwrap_or_else(|e| panic!("{e}"));
        let graph = sketch(&look, &library);
        let [a, b, d] = ["a", "b", "d"].map(|name| graph.node(name).expect("there"));
        assert!(graph.node("c").is_none());
        assert_eq!(graph.value(a, "x"), Some(&Value::F32(2.0)));
        assert_eq!(graph.link(a, "c").map(|l| l.source), Some(b));
        // It would close a circle, and a vector is no number.
        assert_eq!(graph.link(b, "x"), None);
        assert_eq!(graph.link(d, "x"), None);
        assert_eq!(graph.value(d, "c"), Some(&Value::Vec3([1.0; 3])));
        let link = |swizzle: Option<&str>| texgen::Link {
            source: a,
            swizzle: swizzle.map(|s| s.parse().expect("a swizzle")),
        };
        assert!(Output::BASE_COLOR.check(&graph, link(None)).is_ok());
        assert!(Output::ROUGHNESS.check(&graph, link(Some("x"))).is_ok());
        let refused = Output::ROUGHNESS.check(&graph, link(None));
        assert!(refused.is_err_and(|why| why.contains("a.x")));
    }

    #[test]
    fn constants_are_brought_up_to_date() {
        let texture =
            "/// @param x one = 3\nfn userProc(x: f32, c: vec3f) -> vec3f { return c * x; }";
        let texture = TextureType::parse(SourceFile::new("t", "t.wgsl", texture));
        let texture = texture.unwrap_or_else(|e| panic!("{e}"));
        let library = Arc::new(Library::new(vec![texture]).expect("one texture"));
        let parse =
            |text: &str| Look::parse(Path::new("l.toml"), text).unwrap_or_else(|e| panic!("{e}"));
        let text = "[node.a]\ntexture = 't'\nx = 2\n[node.odd]\ntexture = 'u'\n[node.b]\ntexture = 't'\nc = 'a'\n";
        let graph = sketch(&parse(text), &library);
        let again = |text: &str| {
            let mut graph = graph.clone();
            let look = parse(text);
            let is_same = resketch(&mut graph, &look);
            if is_same {
                let new = sketch(&look, &library);
                for node in new.ids() {
                    for parameter in ["x", "c"] {
                        assert_eq!(graph.value(node, parameter), new.value(node, parameter));
                        assert_eq!(graph.link(node, parameter), new.link(node, parameter));
                    }
                }
                assert_eq!(graph.args(), new.args());
            }
            is_same
        };
        for constants in [
            text.to_owned(),
            text.replace("x = 2", "x = 5.5\nc = '#102030'"),
            text.replace("x = 2\n", ""),
            text.replace("x = 2", "x = true"),
            text.replace("c = 'a'", "c = 'a'\nx = 7"),
        ] {
            assert!(again(&constants), "{constants}");
        }
        for others in [
            text.replace("'a'", "'a.xxx'"),
            text.replace("c = 'a'", "c = 1"),
            text.replace("x = 2", "x = 'b.x'"),
            text.replace("[node.a]", "[node.d]"),
            text.replace("'u'", "'t'"),
            format!("{text}[node.e]\ntexture = 't'\n"),
            "[node.a]\ntexture = 't'\n".to_owned(),
        ] {
            assert!(!again(&others), "{others}");
        }
    }
}
