//! The images that a model brings for a material: seen, and made nodes of, so that they can be changed.

use egui::{Ui, vec2};
use engine::scene::look::{Field, MODEL_IMAGE, Section, Spanned, Value};
use engine::scene::{Filter, Material, TextureRef, Wrap};
use engine::session::{Document, Edit};
use glam::Vec3;

use crate::context::Context;
use crate::edits::free_name;
use crate::model_image::DraggedImage;
use crate::widgets::name;

/// What of a material an image of the model is for.
struct Map {
    label: &'static str,
    key: &'static str,
    swizzle: &'static str,
    is_data: bool,
    texture: fn(&Material) -> Option<&TextureRef>,
    /// What its colours are multiplied by.
    factor: fn(&Material) -> Vec3,
}

const MAPS: [Map; 5] = [
    Map {
        label: "Base colour map",
        key: "base_color",
        swizzle: "xyz",
        is_data: false,
        texture: |m| m.base_color_texture.as_ref(),
        factor: |m| m.base_color.truncate(),
    },
    Map {
        label: "Roughness map",
        key: "roughness",
        swizzle: "y",
        is_data: true,
        texture: |m| m.metallic_roughness_texture.as_ref(),
        factor: |m| Vec3::new(1.0, m.roughness, m.metallic),
    },
    Map {
        label: "Metallic map",
        key: "metallic",
        swizzle: "z",
        is_data: true,
        texture: |m| m.metallic_roughness_texture.as_ref(),
        factor: |m| Vec3::new(1.0, m.roughness, m.metallic),
    },
    Map {
        label: "Normal map",
        key: "normal",
        swizzle: "xyz",
        is_data: true,
        texture: |m| m.normal_texture.as_ref(),
        factor: |_| Vec3::ONE,
    },
    Map {
        label: "Emission map",
        key: "emission",
        swizzle: "xyz",
        is_data: false,
        texture: |m| m.emission_texture.as_ref(),
        factor: |m| m.emission,
    },
];

/// Rows of the images that a material has of its model, where no node stands in their place.
pub(crate) fn maps(ui: &mut Ui, cx: &mut Context<'_>, material: &str) {
    let shown = cx.scene_material(material);
    for map in &MAPS {
        let Some(texture) = (map.texture)(shown) else {
            continue;
        };
        let Some(image) = cx.scene.images.get(texture.image as usize) else {
            continue;
        };
        let section = Section::Material(material.to_owned());
        if cx.document.value(&section, map.key).is_some() {
            continue;
        }
        ui.horizontal(|ui| {
            let id = ui.scope_id().with(("drag", material, map.label));
            let payload = DraggedImage {
                name: image.name.clone(),
                is_data: map.is_data,
            };
            let handle = image.picture(ui.ctx());
            let dragged = ui.dnd_drag_source(id, payload, |ui| {
                let size = handle.size_vec2();
                let size = size * (20.0 / size.max_elem());
                ui.add(egui::Image::new((handle.id(), size)).fit_to_exact_size(vec2(20.0, 20.0)));
                ui.label(map.label);
            });
            let [width, height] = image.size;
            let help = "drag it onto the slot of an image, which reads it then";
            let help = format!("{}, {width} x {height}, of the model; {help}", image.name);
            dragged.response.on_hover_text(help);
            let button = ui.button("As a node");
            name(&button, &format!("{} of {material} as a node", map.label));
            let help = "so that it can be graded, mixed, or moved; what it looks like stays, but for colours of the mesh itself and the turn \
                        of an image that is turned";
            if button.on_hover_text(help).clicked() {
                let edits = as_node(cx.document, shown, map, texture, &image.name);
                cx.edit(&format!("{} as a node", map.label), edits, None);
            }
        });
    }
}

/// A node that reads the image as the material did.
fn as_node(
    document: &Document,
    material: &Material,
    map: &Map,
    texture: &TextureRef,
    image: &str,
) -> Vec<Edit> {
    let stem = image.rsplit('/').next().unwrap_or(image);
    let stem = stem.split('.').next().unwrap_or("image");
    let node = free_name(document, stem, &[]);
    let section = || Section::Node(node.clone());
    let field = |key: &str, value: Value| Field {
        key: Spanned::new(key.to_owned(), 0..0),
        value: Spanned::new(value, 0..0),
    };
    let text = |text: &str| Value::Text(text.to_owned());
    let mut file = vec![field("file", Value::Text(format!("{MODEL_IMAGE}{image}")))];
    if map.is_data {
        file.push(field("color_space", text("linear")));
    }
    let wraps = [texture.sampler.wrap_u, texture.sampler.wrap_v];
    if wraps != [Wrap::Repeat; 2] {
        let words = wraps.map(|wrap| match wrap {
            Wrap::Repeat => "repeat",
            Wrap::Mirror => "mirror",
            Wrap::Clamp => "clamp",
        });
        let words = words.map(|word| Spanned::new(text(word), 0..0));
        file.push(field("wrap", Value::List(words.to_vec())));
    }
    if texture.sampler.filter == Filter::Nearest {
        file.push(field("filter", text("nearest")));
    }
    let mut edits = vec![
        Edit::add_node(&node, "image"),
        Edit::set(section(), "file", Value::Table(file)),
    ];
    if texture.uv_set == 1 {
        let place = free_name(document, "coordinates", std::slice::from_ref(&node));
        edits.push(Edit::add_node(&place, "coordinates"));
        let space = Edit::set(Section::Node(place.clone()), "space", Value::Integer(3));
        edits.push(space);
        edits.push(Edit::link(&node, "texcoord", &place));
    }
    // A shift and a scale; what is turned has to be turned by hand.
    let [u, v] = texture.transform;
    let tiling = [u.x, v.y];
    if tiling != [1.0; 2] && tiling.iter().all(|x| *x != 0.0) {
        edits.push(Edit::set(section(), "uvtiling", Value::numbers(&tiling)));
    }
    let offset = [u.z, v.z];
    if offset != [0.0; 2] {
        edits.push(Edit::set(section(), "uvoffset", Value::numbers(&offset)));
    }
    let mut factor = (map.factor)(material);
    let mut own = document.look().materials.iter();
    let own = own.find(|own| own.name.value == material.name);
    let strength = own.and_then(|own| own.constant("emission_strength"));
    if map.key == "emission"
        && let Some(strength) = strength
    {
        // The material's emission has the factor in it that the node's result is multiplied by.
        let is_dark = strength.cmpeq(Vec3::ZERO);
        factor = Vec3::select(is_dark, Vec3::ONE, factor / strength);
    }
    if factor != Vec3::ONE {
        let gain = factor.extend(1.0).to_array();
        edits.push(Edit::set(section(), "gain", Value::numbers(&gain)));
    }
    let mut link = format!("{node}.{}", map.swizzle);
    if map.key == "normal" {
        let normal = free_name(document, "normal_map", std::slice::from_ref(&node));
        edits.push(Edit::add_node(&normal, "normal_map"));
        edits.push(Edit::link(&normal, "color", &link));
        let own = Section::Material(material.name.clone());
        let scale = match document.value(&own, "normal_scale") {
            Some(Value::Text(link)) => Some(Value::Text(link)),
            _ if material.normal_scale == 1.0 => None,
            // The parameter has these bounds.
            _ => Some(Value::number(material.normal_scale.clamp(-10.0, 10.0))),
        };
        if let Some(scale) = scale {
            edits.push(Edit::set(Section::Node(normal.clone()), "scale", scale));
        }
        link = normal;
    }
    edits.push(Edit::material(&material.name, map.key, Value::Text(link)));
    edits
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use engine::scene::Sampler;

    use super::*;

    /// The text of a look once a map is a node.
    fn made(look: &str, key: &str, material: Material, texture: TextureRef) -> String {
        let mut document = Document::new(Path::new("a"), look).expect("a look");
        let map = MAPS.iter().find(|map| map.key == key).expect("a map");
        let material = Material {
            name: "M".to_owned(),
            ..material
        };
        let edits = as_node(&document, &material, map, &texture, "maps/wood.png");
        document.apply("a node", &edits, None).expect("it fits");
        document.text().to_owned()
    }

    fn texture() -> TextureRef {
        TextureRef {
            image: 0,
            uv_set: 0,
            sampler: Sampler::default(),
            transform: [Vec3::X, Vec3::Y],
        }
    }

    #[test]
    fn a_map_that_is_plain_says_no_more_than_its_file() {
        let text = made("", "base_color", Material::default(), texture());
        for expected in ["[node.wood]", "file = ", "\"model:maps/wood.png\""] {
            assert!(text.contains(expected), "{text}");
        }
        for other in ["filter", "texcoord", "gain", "uvtiling", "wrap"] {
            assert!(!text.contains(other), "{text}");
        }
        let text = made("", "normal", Material::default(), texture());
        assert!(!text.contains("scale"), "{text}");
    }

    #[test]
    fn a_node_reads_the_image_as_the_material_did() {
        let mut nearest = texture();
        nearest.sampler.filter = Filter::Nearest;
        let text = made("", "base_color", Material::default(), nearest);
        assert!(text.contains("filter = \"nearest\""), "{text}");

        let second = TextureRef {
            uv_set: 1,
            ..texture()
        };
        let text = made("", "base_color", Material::default(), second);
        for expected in [
            "[node.coordinates]",
            "space = 3",
            "texcoord = \"coordinates\"",
        ] {
            assert!(text.contains(expected), "{text}");
        }
    }

    #[test]
    fn a_normal_map_leans_as_it_did() {
        let material = || Material {
            normal_scale: 0.25,
            ..Material::default()
        };
        let text = made("", "normal", material(), texture());
        assert!(text.contains("scale = 0.25"), "{text}");
        assert!(text.contains("color = \"wood.xyz\""), "{text}");
        // What a node drives has no number.
        let driven = "[node.n]\ntexture = 'noise'\n[material.M]\nnormal_scale = 'n.x'\n";
        let text = made(driven, "normal", material(), texture());
        assert!(text.contains("\nscale = \"n.x\""), "{text}");
    }

    #[test]
    fn what_shines_shines_as_before() {
        let material = |red: f32| Material {
            emission: Vec3::new(red, 2.0, 0.0),
            ..Material::default()
        };
        let text = made("", "emission", material(0.5), texture());
        assert!(text.contains("gain = [0.5, 2.0, 0.0, 1.0]"), "{text}");
        // The strength goes on being a factor of what the node gives.
        let look = "[material.M]\nemission_strength = 4.0\n";
        let text = made(look, "emission", material(1.0), texture());
        assert!(text.contains("gain = [0.25, 0.5, 0.0, 1.0]"), "{text}");
        let look = "[material.M]\nemission_strength = 0.0\n";
        let dark = Material::default();
        let text = made(look, "emission", dark, texture());
        assert!(!text.contains("gain"), "{text}");
    }
}
