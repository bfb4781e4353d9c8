//! Pictures and materials that are dropped where they are to be seen.

use egui::{Response, Stroke, StrokeKind, Ui};
use engine::scene::look::{Field, Section, Spanned, Value};
use engine::session::{Document, Edit};

use crate::Textures;
use crate::context::{Context, own_names};
use crate::edits::{free_name, remove_unused};
use crate::model::Model;
use crate::scene_view::SceneView;

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
///
/// # Errors
/// `target` is a part of `material` already, so that it would be blended of itself.
pub fn give_material(
    document: &Document,
    textures: &Textures,
    scene: SceneView<'_>,
    target: &str,
    material: &str,
) -> Result<Vec<Edit>, String> {
    let model = Model::new(document, &textures.library);
    let is_own = |name: &str| own_names(scene).any(|own| own == name);
    given(document, &model, is_own, [target, material])
}

/// The same with what is known of the look. `is_own` tells the materials of the scene's files.
fn given(
    document: &Document,
    model: &Model,
    is_own: impl Fn(&str) -> bool,
    [target, material]: [&str; 2],
) -> Result<Vec<Edit>, String> {
    if model.is_made_of(material, target) {
        return Err(format!("`{material}` is made of `{target}` already"));
    }
    let text = |text: &str| Value::Text(text.to_owned());
    let mut edits = vec![
        Edit::material(target, "blend.base", text(target)),
        Edit::material(target, "blend.over", text(material)),
        Edit::material(target, "blend.mask", Value::number(1.0)),
    ];
    // What the former blend was of may have no other one.
    let sides = [target, material];
    edits.extend(remove_unused(document, model, is_own, target, &sides));
    Ok(edits)
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
    let is_own = |name: &str| cx.is_own(name);
    let edits = given(cx.document, cx.model, is_own, [target, material]);
    cx.edit_if(&format!("{material} on {target}"), edits);
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use engine::scene::Material;

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

    /// What comes of a material that is dropped on another one, of a scene that has Iron and Steel.
    fn dropped(look: &str, target: &str, material: &str) -> Result<String, String> {
        let mut document = Document::new(Path::new("a.look.toml"), look).expect("a look");
        let materials = ["Iron", "Steel"].map(|name| Material {
            name: name.to_owned(),
            ..Material::default()
        });
        let scene = SceneView {
            materials: &materials,
            own: materials.len(),
            images: &[],
            lights: &[],
            camera: None,
        };
        let edits = give_material(&document, &Textures::default(), scene, target, material)?;
        document.apply("give", &edits, None)?;
        Ok(document.text().to_owned())
    }

    #[test]
    fn a_material_is_given() {
        let text = dropped("[material.Steel]\nmetallic = 1.0\n", "Iron", "Steel");
        let text = text.expect("it fits");
        let blend = "blend = { base = \"Iron\", over = \"Steel\", mask = 1.0 }";
        assert!(text.contains(blend), "{text}");
    }

    #[test]
    fn a_material_that_nothing_is_blended_of_any_more_goes() {
        let look = "[material.Iron]\nblend = { base = 'Iron', over = 'Rust', mask = 0.5 }\n\n\
                    [material.Rust]\nblend = { base = 'Rust', over = 'Dust', mask = 0.5 }\n\n\
                    [material.Dust]\nroughness = 1.0\n";
        let text = dropped(look, "Iron", "Steel").expect("it fits");
        assert!(!text.contains("Rust") && !text.contains("Dust"), "{text}");
        // What is dropped stays.
        let text = dropped(look, "Iron", "Dust").expect("it fits");
        assert!(!text.contains("Rust"), "{text}");
        assert!(text.contains("[material.Dust]"), "{text}");
        // Another blend has it.
        let both = format!(
            "{look}\n[material.Steel]\nblend = {{ base = 'Steel', over = 'Rust', mask = 0.5 }}\n"
        );
        let text = dropped(&both, "Iron", "Steel").expect("it fits");
        assert!(text.contains("[material.Rust]"), "{text}");
    }

    #[test]
    fn a_material_is_no_part_of_itself() {
        let look = "[material.Iron]\nblend = { base = 'Iron', over = 'Rust', mask = 0.5 }\n\n\
                    [material.Rust]\nblend = { base = 'Rust', over = 'Steel', mask = 0.5 }\n";
        for (target, material) in [("Steel", "Iron"), ("Rust", "Iron"), ("Steel", "Rust")] {
            let why = dropped(look, target, material).expect_err("a circle");
            assert!(why.contains(target) && why.contains(material), "{why}");
        }
    }
}
