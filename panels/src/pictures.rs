//! Pictures and materials that are dropped where they are to be seen.

use egui::{Response, Stroke, StrokeKind, Ui};
use engine::scene::look::{Field, Section, Spanned, Value};
use engine::session::{Document, Edit};

use crate::context::Context;
use crate::edits::free_name;

/// What a picture can be of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PictureUse {
    /// For people.
    pub label: &'static str,
    /// Of the material.
    key: &'static str,
    /// Its components that are read.
    swizzle: &'static str,
    /// It holds numbers, not colours.
    is_data: bool,
}

impl PictureUse {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::color("Base colour", "base_color"),
        Self::data("Roughness", "roughness", "x"),
        Self::data("Metallic", "metallic", "x"),
        Self::data("Normal map", "normal", "xyz"),
        Self::data("Bump", "bump", "x"),
        Self::data("Opacity", "opacity", "x"),
        Self::color("Emission", "emission"),
    ];

    const fn color(label: &'static str, key: &'static str) -> Self {
        Self {
            label,
            key,
            swizzle: "xyz",
            is_data: false,
        }
    }

    const fn data(label: &'static str, key: &'static str, swizzle: &'static str) -> Self {
        Self {
            label,
            key,
            swizzle,
            is_data: true,
        }
    }

    /// A node of the picture at `path`, as the look names it, that drives this of a material.
    pub fn edits(self, document: &Document, path: &str, material: &str) -> Vec<Edit> {
        let stem = path.rsplit(['/', '\\']).next().unwrap_or(path);
        let stem = stem.split('.').next().unwrap_or("image");
        let node = free_name(document, stem, &[]);
        let file = Value::Text(path.to_owned());
        let file = match self.is_data {
            false => file,
            true => {
                let field = |key: &str, value: Value| Field {
                    key: Spanned::new(key.to_owned(), 0..0),
                    value: Spanned::new(value, 0..0),
                };
                let space = Value::Text("linear".to_owned());
                Value::Table(vec![field("file", file), field("color_space", space)])
            }
        };
        let mut edits = vec![
            Edit::add_node(&node, "image"),
            Edit::set(Section::Node(node.clone()), "file", file),
        ];
        let mut link = format!("{node}.{}", self.swizzle);
        if self.key == "normal" {
            let map = free_name(document, "normal_map", &[node]);
            let section = Section::Node(map.clone());
            edits.push(Edit::add_node(&map, "normal_map"));
            edits.push(Edit::set(section, "color", Value::Text(link)));
            link = map;
        }
        edits.push(Edit::material(material, self.key, Value::Text(link)));
        edits
    }
}

/// A material that is dragged from the panel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DraggedMaterial(pub String);

/// Makes all that has the material `target` look like `material`: a blend that shows nothing else.
pub fn give_material(target: &str, material: &str) -> Vec<Edit> {
    let text = |text: &str| Value::Text(text.to_owned());
    vec![
        Edit::material(target, "blend.base", text(target)),
        Edit::material(target, "blend.over", text(material)),
        Edit::material(target, "blend.mask", Value::number(1.0)),
    ]
}

/// A material that is dropped on something of another one is given to that.
pub(crate) fn take_material(ui: &Ui, cx: &mut Context<'_>, target: &str, place: &Response) {
    let is_other = |dragged: &DraggedMaterial| dragged.0 != target;
    if place
        .dnd_hover_payload::<DraggedMaterial>()
        .is_some_and(|dragged| is_other(&dragged))
    {
        let stroke = Stroke::new(2.0, ui.visuals().selection.bg_fill);
        let painter = ui.painter();
        painter.rect_stroke(place.rect, 2.0, stroke, StrokeKind::Inside);
    }
    let Some(dragged) = place.dnd_release_payload::<DraggedMaterial>() else {
        return;
    };
    if !is_other(&dragged) {
        return;
    }
    let material = &dragged.0;
    // A material of which this one is a part would close a circle.
    let edits = match cx.model.is_made_of(material, target) {
        true => Err(format!("`{material}` is made of `{target}` already")),
        false => Ok(give_material(target, material)),
    };
    cx.edit_if(&format!("{material} on {target}"), edits);
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn pictures_become_nodes_that_drive_a_material() {
        let mut document = Document::new(Path::new("a.look.toml"), "").expect("a look");
        for way in PictureUse::ALL {
            let edits = way.edits(&document, "maps/oak.v2.png", "Wood");
            document.apply(way.label, &edits, None).expect(way.label);
        }
        let text = document.text();
        for line in [
            "base_color = \"oak.xyz\"",
            "roughness = \"oak_2.x\"",
            "normal = \"normal_map\"",
            "file = \"maps/oak.v2.png\"",
            "color_space = \"linear\"",
        ] {
            assert!(text.contains(line), "{line} is missing:\n{text}");
        }
    }

    #[test]
    fn a_material_is_given() {
        let look = "[material.Gold]\nmetallic = 1.0\n";
        let mut document = Document::new(Path::new("a.look.toml"), look).expect("a look");
        let edits = give_material("Iron", "Gold");
        document.apply("give", &edits, None).expect("it fits");
        assert!(
            document.text().contains("mask = 1.0"),
            "{}",
            document.text()
        );
    }
}
