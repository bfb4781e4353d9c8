//! The images that a model brings for a material: seen, and made nodes of, so that they can be changed.

use egui::{Ui, vec2};
use engine::scene::look::{Field, MODEL_IMAGE, Section, Spanned, Value};
use engine::scene::{Material, TextureRef, Wrap};
use engine::session::Edit;
use glam::Vec3;

use crate::context::Context;
use crate::edits::free_name;
use crate::model_image::{DraggedImage, ModelImage};
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
        factor: |_| Vec3::ONE,
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
            let handle = image.picture(ui.ctx(), texture.image as usize);
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
            let help = "so that it can be graded, mixed, or moved; what it looks like stays";
            if button.on_hover_text(help).clicked() {
                let edits = as_node(cx, material, map, texture, image);
                cx.edit(&format!("{} as a node", map.label), edits, None);
            }
        });
    }
}

/// A node that reads the image as the material did.
fn as_node(
    cx: &Context<'_>,
    material: &str,
    map: &Map,
    texture: &TextureRef,
    image: &ModelImage,
) -> Vec<Edit> {
    let stem = image.name.rsplit('/').next().unwrap_or(&image.name);
    let stem = stem.split('.').next().unwrap_or("image");
    let node = free_name(cx.document, stem, &[]);
    let section = || Section::Node(node.clone());
    let field = |key: &str, value: Value| Field {
        key: Spanned::new(key.to_owned(), 0..0),
        value: Spanned::new(value, 0..0),
    };
    let text = |text: &str| Value::Text(text.to_owned());
    let mut file = vec![field(
        "file",
        Value::Text(format!("{MODEL_IMAGE}{}", image.name)),
    )];
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
    let mut edits = vec![
        Edit::add_node(&node, "image"),
        Edit::set(section(), "file", Value::Table(file)),
    ];
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
    let factor = (map.factor)(cx.scene_material(material));
    if factor != Vec3::ONE {
        let gain = factor.extend(1.0).to_array();
        edits.push(Edit::set(section(), "gain", Value::numbers(&gain)));
    }
    let mut link = format!("{node}.{}", map.swizzle);
    if map.key == "normal" {
        let normal = free_name(cx.document, "normal_map", std::slice::from_ref(&node));
        let section = Section::Node(normal.clone());
        edits.push(Edit::add_node(&normal, "normal_map"));
        edits.push(Edit::set(section, "color", Value::Text(link)));
        link = normal;
    }
    edits.push(Edit::material(material, map.key, Value::Text(link)));
    edits
}
