//! What a document has become as the text of a look.

use scene::look::{LookDocument, Section, Value};

use crate::convert::Converted;

/// Nodes and materials as tables of a look, in their order.
pub fn look_text(converted: &Converted) -> String {
    let mut look = LookDocument::empty();
    let mut set = |section: &Section, key: &str, value: &Value| {
        // Nothing is in the way: each table is new.
        look.set(section, key, value).is_ok()
    };
    for node in &converted.nodes {
        let section = Section::Node(node.name.clone());
        set(&section, "texture", &Value::Text(node.texture.clone()));
        for (key, value) in &node.arguments {
            set(&section, key, value);
        }
    }
    for material in &converted.materials {
        let section = Section::Material(material.name.clone());
        for (key, value) in &material.parameters {
            set(&section, key, value);
        }
    }
    look.text()
}
