//! Materials with their extensions, textures, and pictures as PNG.

use std::collections::HashMap;

use glam::{Vec3, Vec4};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;
use serde_json::{Map, Value, json};

use crate::{AlphaMode, Filter, Material, Sampler, Scene, TextureRef, Wrap};

use super::{ExportError, Tree};

/// Textures and samplers of a file, each once.
#[derive(Debug, Default)]
struct Textures {
    textures: Vec<Value>,
    samplers: Vec<Value>,
    images: Vec<u32>,
    known: HashMap<(u32, Sampler), usize>,
}

/// All materials; their textures, samplers and pictures go to the root.
pub(super) fn materials(
    scene: &Scene,
    tree: &mut Tree,
    root: &mut Map<String, Value>,
) -> Result<Vec<Value>, ExportError> {
    let mut textures = Textures::default();
    let list: Vec<Value> = (scene.materials.iter())
        .map(|material| material_of(material, &mut textures, tree))
        .collect();
    let encoded: Vec<Vec<u8>> = (textures.images.par_iter())
        .map(|&image| png(scene, image))
        .collect::<Result<_, _>>()?;
    let mut images = Vec::new();
    for (&image, png) in textures.images.iter().zip(encoded) {
        let view = tree.buffer.view(&png, None);
        let name = &scene.images[image as usize].name;
        images.push(json!({ "bufferView": view, "mimeType": "image/png", "name": name }));
    }
    for (key, list) in [
        ("textures", textures.textures),
        ("samplers", textures.samplers),
        ("images", images),
    ] {
        if !list.is_empty() {
            root.insert(key.to_owned(), Value::Array(list));
        }
    }
    Ok(list)
}

fn png(scene: &Scene, image: u32) -> Result<Vec<u8>, ExportError> {
    let image = &scene.images[image as usize];
    let mut bytes = Vec::new();
    let failed = |reason: String| ExportError::Picture {
        name: image.name.clone(),
        reason,
    };
    let is_opaque = image.rgba8.chunks_exact(4).all(|texel| texel[3] == 255);
    let (pixels, color): (Vec<u8>, _) = match is_opaque {
        true => {
            let rgb = image.rgba8.chunks_exact(4).flat_map(|t| [t[0], t[1], t[2]]);
            (rgb.collect(), ExtendedColorType::Rgb8)
        }
        false => (image.rgba8.to_vec(), ExtendedColorType::Rgba8),
    };
    PngEncoder::new(&mut bytes)
        .write_image(&pixels, image.width, image.height, color)
        .map_err(|error| failed(error.to_string()))?;
    Ok(bytes)
}

impl Textures {
    /// A texture info; nothing where there is no texture.
    fn info(&mut self, texture: &Option<TextureRef>, tree: &mut Tree) -> Option<Value> {
        let texture = texture.as_ref()?;
        let index = self.texture(texture);
        let mut info = json!({ "index": index });
        if texture.uv_set != 0 {
            info["texCoord"] = json!(texture.uv_set);
        }
        if let Some(transform) = transform(texture) {
            let extension = tree.uses("KHR_texture_transform");
            info["extensions"] = json!({ extension: transform });
        }
        Some(info)
    }

    fn texture(&mut self, texture: &TextureRef) -> usize {
        let key = (texture.image, texture.sampler);
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let image = match self.images.iter().position(|&i| i == texture.image) {
            Some(place) => place,
            None => {
                self.images.push(texture.image);
                self.images.len() - 1
            }
        };
        let sampler = sampler(&texture.sampler);
        let place = self.samplers.iter().position(|known| *known == sampler);
        let sampler = place.unwrap_or_else(|| {
            self.samplers.push(sampler);
            self.samplers.len() - 1
        });
        self.textures
            .push(json!({ "source": image, "sampler": sampler }));
        self.known.insert(key, self.textures.len() - 1);
        self.textures.len() - 1
    }
}

fn sampler(sampler: &Sampler) -> Value {
    let wrap = |wrap: Wrap| match wrap {
        Wrap::Repeat => 10497,
        Wrap::Mirror => 33648,
        Wrap::Clamp => 33071,
    };
    let (magnified, shrunk) = match sampler.filter {
        Filter::Linear => (9729, 9987),
        Filter::Nearest => (9728, 9984),
    };
    json!({
        "magFilter": magnified, "minFilter": shrunk,
        "wrapS": wrap(sampler.wrap_u), "wrapT": wrap(sampler.wrap_v),
    })
}

/// KHR_texture_transform; nothing where the map changes nothing. The extension has no shear.
fn transform(texture: &TextureRef) -> Option<Value> {
    let [u, v] = texture.transform;
    if u == Vec3::X && v == Vec3::Y {
        return None;
    }
    // u' = scale_x cos u + scale_y sin v, v' = -scale_x sin u + scale_y cos v.
    let rotation = match u.x == 0.0 && v.x == 0.0 {
        true => u.y.atan2(v.y),
        false => (-v.x).atan2(u.x),
    };
    let scale = [
        u.x.hypot(v.x),
        (u.y * rotation.sin() + v.y * rotation.cos()),
    ];
    Some(json!({ "offset": [u.z, v.z], "rotation": rotation, "scale": scale }))
}

fn material_of(m: &Material, textures: &mut Textures, tree: &mut Tree) -> Value {
    let mut pbr = json!({
        "baseColorFactor": m.base_color.clamp(Vec4::ZERO, Vec4::ONE).to_array(),
        "metallicFactor": m.metallic.clamp(0.0, 1.0),
        "roughnessFactor": m.roughness.clamp(0.0, 1.0),
    });
    let mut info = |texture: &Option<TextureRef>, tree: &mut Tree| textures.info(texture, tree);
    put(
        &mut pbr,
        "baseColorTexture",
        info(&m.base_color_texture, tree),
    );
    let rough = info(&m.metallic_roughness_texture, tree);
    put(&mut pbr, "metallicRoughnessTexture", rough);
    let mut value = json!({ "name": m.name, "pbrMetallicRoughness": pbr });
    for (key, is_said) in [
        ("priority", m.priority != 0),
        ("shadow_catcher", m.shadow_catcher),
    ] {
        if is_said {
            let warning = format!("material \"{}\": glTF has no word for its `{key}`", m.name);
            tree.warnings.push(warning);
        }
    }
    if m.double_sided {
        value["doubleSided"] = json!(true);
    }
    match m.alpha_mode {
        AlphaMode::Opaque => {}
        AlphaMode::Mask { cutoff } => {
            value["alphaMode"] = json!("MASK");
            value["alphaCutoff"] = json!(cutoff);
        }
        AlphaMode::Blend => value["alphaMode"] = json!("BLEND"),
    }
    if let Some(mut normal) = info(&m.normal_texture, tree) {
        normal["scale"] = json!(m.normal_scale);
        value["normalTexture"] = normal;
    }
    // Factors are at most 1; what is brighter is said by an extension.
    let strength = m.emission.max_element().max(1.0);
    if m.emission.max_element() > 0.0 {
        value["emissiveFactor"] = json!((m.emission / strength).to_array());
        put(
            &mut value,
            "emissiveTexture",
            info(&m.emission_texture, tree),
        );
    }
    let mut extensions = Map::new();
    let mut add = |tree: &mut Tree, name: &'static str, fields: Vec<(&str, Option<Value>)>| {
        let fields = fields
            .into_iter()
            .filter_map(|(key, value)| Some((key.to_owned(), value?)));
        extensions.insert(tree.uses(name).to_owned(), Value::Object(fields.collect()));
    };
    let some = |value: f32| Some(json!(value));
    let rgb = |color: Vec3| Some(json!(color.max(Vec3::ZERO).to_array()));
    if strength > 1.0 {
        add(
            tree,
            "KHR_materials_emissive_strength",
            vec![("emissiveStrength", some(strength))],
        );
    }
    if m.unlit {
        add(tree, "KHR_materials_unlit", Vec::new());
    }
    if m.ior != 1.5 {
        add(tree, "KHR_materials_ior", vec![("ior", some(m.ior))]);
    }
    let has_specular = m.specular != 1.0
        || m.specular_color != Vec3::ONE
        || m.specular_texture.is_some()
        || m.specular_color_texture.is_some();
    if has_specular {
        let fields = vec![
            ("specularFactor", some(m.specular)),
            ("specularColorFactor", rgb(m.specular_color)),
            ("specularTexture", info(&m.specular_texture, tree)),
            (
                "specularColorTexture",
                info(&m.specular_color_texture, tree),
            ),
        ];
        add(tree, "KHR_materials_specular", fields);
    }
    if m.transmission > 0.0 {
        let texture = info(&m.transmission_texture, tree);
        let fields = vec![
            ("transmissionFactor", some(m.transmission)),
            ("transmissionTexture", texture),
        ];
        add(tree, "KHR_materials_transmission", fields);
    }
    // Without light that goes through, a volume means nothing, and validators warn of it.
    if m.is_solid && (m.transmission > 0.0 || m.diffuse_transmission > 0.0) {
        let mut fields = vec![("thicknessFactor", some(1.0))];
        if m.absorption.max_element() > 0.0 {
            // Over such a way the strongest absorption leaves a third.
            let distance = 1.0 / m.absorption.max_element();
            let color = (-m.absorption * distance).map(f32::exp);
            fields.push(("attenuationDistance", some(distance)));
            fields.push(("attenuationColor", rgb(color)));
        }
        add(tree, "KHR_materials_volume", fields);
        if m.dispersion > 0.0 {
            add(
                tree,
                "KHR_materials_dispersion",
                vec![("dispersion", some(m.dispersion))],
            );
        }
    }
    if m.diffuse_transmission > 0.0 {
        let fields = vec![
            ("diffuseTransmissionFactor", some(m.diffuse_transmission)),
            (
                "diffuseTransmissionColorFactor",
                rgb(m.diffuse_transmission_color),
            ),
            (
                "diffuseTransmissionTexture",
                info(&m.diffuse_transmission_texture, tree),
            ),
            (
                "diffuseTransmissionColorTexture",
                info(&m.diffuse_transmission_color_texture, tree),
            ),
        ];
        add(tree, "KHR_materials_diffuse_transmission", fields);
    }
    if m.sheen_color.max_element() > 0.0 {
        let fields = vec![
            ("sheenColorFactor", rgb(m.sheen_color)),
            ("sheenRoughnessFactor", some(m.sheen_roughness)),
            ("sheenColorTexture", info(&m.sheen_color_texture, tree)),
            (
                "sheenRoughnessTexture",
                info(&m.sheen_roughness_texture, tree),
            ),
        ];
        add(tree, "KHR_materials_sheen", fields);
    }
    if m.coat > 0.0 {
        let normal = info(&m.coat_normal_texture, tree).map(|mut normal| {
            normal["scale"] = json!(m.coat_normal_scale);
            normal
        });
        let fields = vec![
            ("clearcoatFactor", some(m.coat)),
            ("clearcoatRoughnessFactor", some(m.coat_roughness)),
            ("clearcoatTexture", info(&m.coat_texture, tree)),
            (
                "clearcoatRoughnessTexture",
                info(&m.coat_roughness_texture, tree),
            ),
            ("clearcoatNormalTexture", normal),
        ];
        add(tree, "KHR_materials_clearcoat", fields);
    }
    if m.anisotropy > 0.0 {
        let fields = vec![
            ("anisotropyStrength", some(m.anisotropy)),
            ("anisotropyRotation", some(m.anisotropy_rotation)),
            ("anisotropyTexture", info(&m.anisotropy_texture, tree)),
        ];
        add(tree, "KHR_materials_anisotropy", fields);
    }
    if m.iridescence > 0.0 {
        let [thin, thick] = m.iridescence_thickness;
        let fields = vec![
            ("iridescenceFactor", some(m.iridescence)),
            ("iridescenceIor", some(m.iridescence_ior)),
            ("iridescenceThicknessMinimum", some(thin)),
            ("iridescenceThicknessMaximum", some(thick)),
            ("iridescenceTexture", info(&m.iridescence_texture, tree)),
            (
                "iridescenceThicknessTexture",
                info(&m.iridescence_thickness_texture, tree),
            ),
        ];
        add(tree, "KHR_materials_iridescence", fields);
    }
    if !extensions.is_empty() {
        value["extensions"] = Value::Object(extensions);
    }
    value
}

fn put(value: &mut Value, key: &str, field: Option<Value>) {
    if let Some(field) = field {
        value[key] = field;
    }
}
