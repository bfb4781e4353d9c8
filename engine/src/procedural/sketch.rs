//! The graph of a look on its own, without scene, images or programs: what an editor shows, and asks whether a link fits.

use std::sync::Arc;

use texgen::{Graph, Library};

use crate::scene::look::Look;

use super::values::{Argument, argument};
use super::wiring::check_driver;
use super::{Output, Source};

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

impl Output {
    /// Checks that a link of `graph` can drive this.
    ///
    /// # Errors
    /// Says what to do instead.
    pub fn check(self, graph: &Graph, link: texgen::Link) -> Result<(), String> {
        let texgen::Link { source, swizzle } = link;
        let source = Source {
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
        assert!(Output::BaseColor.check(&graph, link(None)).is_ok());
        assert!(Output::Roughness.check(&graph, link(Some("x"))).is_ok());
        let refused = Output::Roughness.check(&graph, link(None));
        assert!(refused.is_err_and(|why| why.contains("a.x")));
    }
}
