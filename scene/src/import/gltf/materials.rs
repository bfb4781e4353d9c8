//! glTF materials to [`Material`], and the list of pictures they need.

use super::document::Document;
use super::layers;
use super::reader::{ImageRequests, MOST, Reader, other_transform};
use crate::import::error::{At as _, Fault, ImportError, Warnings};
use crate::import::pictures::Album as _;
use crate::{AlphaMode, Material};
use gltf::json;
use json::validation::Checked;
use std::collections::HashMap;

/// Name of the material of primitives that have none.
const DEFAULT_NAME: &str = "default";

/// Reads all materials. Behind them stands the one for primitives that have none.
pub(super) fn read(
    document: &Document,
    warnings: &mut Warnings,
) -> Result<(Vec<Material>, ImageRequests), ImportError> {
    let mut reader = Reader::new(&document.root, first_uses(document), warnings);
    let mut materials = Vec::with_capacity(document.root.materials.len() + 1);
    for (index, source) in document.root.materials.iter().enumerate() {
        let name = source.name.clone().filter(|name| !name.is_empty());
        let name = name.unwrap_or_else(|| format!("material {index}"));
        reader.place = format!("material {index} \"{name}\"");
        let mut material = material(&mut reader, source)
            .at(&document.path, || format!("material {index} \"{name}\""))?;
        material.name = name;
        materials.push(material);
    }
    materials.push(Material {
        name: DEFAULT_NAME.into(),
        ..Material::default()
    });
    Ok((materials, reader.requests))
}

/// For each image of the file the first one with the same bytes.
fn first_uses(document: &Document) -> Vec<usize> {
    let mut firsts = HashMap::new();
    (0..document.root.images.len())
        .map(|index| *firsts.entry(document.key(index)).or_insert(index))
        .collect()
}

fn material(reader: &mut Reader<'_>, source: &json::Material) -> Result<Material, Fault> {
    let pbr = &source.pbr_metallic_roughness;
    let mut material = Material {
        base_color: reader.unit4("baseColorFactor", pbr.base_color_factor.0),
        base_color_texture: reader.info(&pbr.base_color_texture, true)?,
        metallic: reader.unit("metallicFactor", pbr.metallic_factor.0),
        roughness: reader.unit("roughnessFactor", pbr.roughness_factor.0),
        metallic_roughness_texture: reader.info(&pbr.metallic_roughness_texture, false)?,
        emission: reader.positive3("emissiveFactor", source.emissive_factor.0),
        emission_texture: reader.info(&source.emissive_texture, true)?,
        alpha_mode: match source.alpha_mode {
            Checked::Valid(json::material::AlphaMode::Opaque) => AlphaMode::Opaque,
            Checked::Valid(json::material::AlphaMode::Blend) => AlphaMode::Blend,
            Checked::Valid(json::material::AlphaMode::Mask) => {
                let cutoff = source.alpha_cutoff.unwrap_or_default().0;
                AlphaMode::Mask {
                    cutoff: reader.within("alphaCutoff", cutoff, 0.0, f32::MAX, 0.5),
                }
            }
            Checked::Invalid => return Err("has an unknown alphaMode".into()),
        },
        double_sided: source.double_sided,
        ..Material::default()
    };
    if let Some(normal) = &source.normal_texture {
        let transform = other_transform(normal.extensions.as_ref().map(|e| &e.others))?;
        material.normal_texture = reader.texture(
            normal.index.value(),
            normal.tex_coord,
            transform.as_ref(),
            false,
        )?;
        material.normal_scale =
            reader.within("normalTexture.scale", normal.scale, -MOST, MOST, 1.0);
    }
    if let Some(extensions) = &source.extensions {
        extensions_of(reader, extensions, &mut material)?;
    }
    // The occlusion texture is for renderers that do not compute occlusion.
    Ok(material)
}

fn extensions_of(
    reader: &mut Reader<'_>,
    extensions: &json::extensions::material::Material,
    material: &mut Material,
) -> Result<(), Fault> {
    material.unlit = extensions.unlit.is_some();
    if let Some(strength) = &extensions.emissive_strength {
        let strength = strength.emissive_strength.0;
        let strength = reader.within("emissiveStrength", strength, 0.0, f32::MAX, 1.0);
        let emission = (material.emission * strength).to_array();
        material.emission = reader.positive3("emissiveFactor times emissiveStrength", emission);
    }
    if let Some(ior) = &extensions.ior {
        // 0 stands for an infinite index, as the extension defines it: all light is reflected.
        material.ior = match ior.ior.0 {
            0.0 => 0.0,
            ior => reader.within("ior", ior, 1.0, f32::MAX, 1.5),
        };
    }
    if let Some(specular) = &extensions.specular {
        material.specular = reader.unit("specularFactor", specular.specular_factor.0);
        material.specular_texture = reader.info(&specular.specular_texture, false)?;
        material.specular_color =
            reader.positive3("specularColorFactor", specular.specular_color_factor.0);
        material.specular_color_texture = reader.info(&specular.specular_color_texture, true)?;
    }
    layers::read(reader, &extensions.others, material)
}
