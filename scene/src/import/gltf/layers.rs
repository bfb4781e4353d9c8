//! The extensions of glTF materials that the JSON reader leaves as they are: transmission, volume, diffuse transmission,
//! sheen, clearcoat, anisotropy and iridescence.

use glam::Vec3;
use gltf::json;
use serde_json::{Map, Value};

use super::reader::{MOST, Reader, other_transform};
use crate::import::error::Fault;
use crate::{Material, TextureRef};

type Extension<'e> = &'e Map<String, Value>;

/// Takes from an extension what it says of a material.
type Read = fn(&mut Reader<'_>, Extension<'_>, &mut Material) -> Result<(), Fault>;

/// The extensions, and what reads each.
const EXTENSIONS: [(&str, Read); 8] = [
    ("KHR_materials_transmission", transmission),
    ("KHR_materials_volume", volume),
    ("KHR_materials_dispersion", dispersion),
    ("KHR_materials_diffuse_transmission", diffuse_transmission),
    ("KHR_materials_sheen", sheen),
    ("KHR_materials_clearcoat", coat),
    ("KHR_materials_anisotropy", anisotropy),
    ("KHR_materials_iridescence", iridescence),
];

/// The names of the extensions that are read here.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    EXTENSIONS.iter().map(|(name, _)| *name)
}

/// Reads what a material's extensions say.
pub(super) fn read(
    reader: &mut Reader<'_>,
    extensions: Extension<'_>,
    material: &mut Material,
) -> Result<(), Fault> {
    for (name, read) in EXTENSIONS {
        if let Some(extension) = extensions.get(name).and_then(Value::as_object) {
            read(reader, extension, material)?;
        }
    }
    Ok(())
}

fn transmission(
    reader: &mut Reader<'_>,
    e: Extension<'_>,
    material: &mut Material,
) -> Result<(), Fault> {
    material.transmission = reader.share(e, "transmissionFactor", 0.0);
    material.transmission_texture = reader.picture(e, "transmissionTexture", false)?;
    Ok(())
}

fn volume(reader: &mut Reader<'_>, e: Extension<'_>, material: &mut Material) -> Result<(), Fault> {
    material.is_solid = reader.number(e, "thicknessFactor", 0.0) > 0.0;
    let color = reader.color(e, "attenuationColor", Vec3::ONE);
    let distance = reader.number(e, "attenuationDistance", f32::INFINITY);
    material.attenuation_color = color;
    if distance > 0.0 && distance.is_finite() {
        material.attenuate(color, distance);
    }
    Ok(())
}

fn dispersion(
    reader: &mut Reader<'_>,
    e: Extension<'_>,
    material: &mut Material,
) -> Result<(), Fault> {
    let dispersion = reader.number(e, "dispersion", 0.0);
    material.dispersion = reader.within("dispersion", dispersion, 0.0, 1e3, 0.0);
    Ok(())
}

fn diffuse_transmission(
    reader: &mut Reader<'_>,
    e: Extension<'_>,
    material: &mut Material,
) -> Result<(), Fault> {
    material.diffuse_transmission = reader.share(e, "diffuseTransmissionFactor", 0.0);
    material.diffuse_transmission_texture =
        reader.picture(e, "diffuseTransmissionTexture", false)?;
    material.diffuse_transmission_color =
        reader.color(e, "diffuseTransmissionColorFactor", Vec3::ONE);
    material.diffuse_transmission_color_texture =
        reader.picture(e, "diffuseTransmissionColorTexture", true)?;
    Ok(())
}

fn sheen(reader: &mut Reader<'_>, e: Extension<'_>, material: &mut Material) -> Result<(), Fault> {
    material.sheen_color = reader.color(e, "sheenColorFactor", Vec3::ZERO);
    material.sheen_color_texture = reader.picture(e, "sheenColorTexture", true)?;
    material.sheen_roughness = reader.share(e, "sheenRoughnessFactor", 0.0);
    material.sheen_roughness_texture = reader.picture(e, "sheenRoughnessTexture", false)?;
    Ok(())
}

fn coat(reader: &mut Reader<'_>, e: Extension<'_>, material: &mut Material) -> Result<(), Fault> {
    material.coat = reader.share(e, "clearcoatFactor", 0.0);
    material.coat_texture = reader.picture(e, "clearcoatTexture", false)?;
    material.coat_roughness = reader.share(e, "clearcoatRoughnessFactor", 0.0);
    material.coat_roughness_texture = reader.picture(e, "clearcoatRoughnessTexture", false)?;
    material.coat_normal_texture = reader.picture(e, "clearcoatNormalTexture", false)?;
    if let Some(normal) = e.get("clearcoatNormalTexture").and_then(Value::as_object) {
        let scale = reader.number(normal, "scale", 1.0);
        material.coat_normal_scale =
            reader.within("clearcoatNormalTexture.scale", scale, -MOST, MOST, 1.0);
    }
    Ok(())
}

fn anisotropy(
    reader: &mut Reader<'_>,
    e: Extension<'_>,
    material: &mut Material,
) -> Result<(), Fault> {
    material.anisotropy = reader.share(e, "anisotropyStrength", 0.0);
    let rotation = reader.number(e, "anisotropyRotation", 0.0);
    material.anisotropy_rotation = reader.within("anisotropyRotation", rotation, -MOST, MOST, 0.0);
    material.anisotropy_texture = reader.picture(e, "anisotropyTexture", false)?;
    Ok(())
}

fn iridescence(
    reader: &mut Reader<'_>,
    e: Extension<'_>,
    material: &mut Material,
) -> Result<(), Fault> {
    material.iridescence = reader.share(e, "iridescenceFactor", 0.0);
    material.iridescence_texture = reader.picture(e, "iridescenceTexture", false)?;
    let ior = reader.number(e, "iridescenceIor", 1.3);
    material.iridescence_ior = reader.within("iridescenceIor", ior, 1.0, 100.0, 1.3);
    let mut thickness = |name: &str, default: f32| {
        let given = reader.number(e, name, default);
        reader.within(name, given, 0.0, 1e6, default)
    };
    material.iridescence_thickness = [
        thickness("iridescenceThicknessMinimum", 100.0),
        thickness("iridescenceThicknessMaximum", 400.0),
    ];
    material.iridescence_thickness_texture =
        reader.picture(e, "iridescenceThicknessTexture", false)?;
    Ok(())
}

impl Reader<'_> {
    fn number(&mut self, e: Extension<'_>, name: &str, default: f32) -> f32 {
        let given = e.get(name).and_then(Value::as_f64);
        let value = given.map_or(default, |value| value as f32);
        if value.is_nan() { default } else { value }
    }

    /// A number of 0 to 1.
    fn share(&mut self, e: Extension<'_>, name: &str, default: f32) -> f32 {
        let value = self.number(e, name, default);
        self.unit(name, value)
    }

    fn color(&mut self, e: Extension<'_>, name: &str, default: Vec3) -> Vec3 {
        let list = e.get(name).and_then(Value::as_array);
        let Some(list) = list.filter(|list| list.len() == 3) else {
            return default;
        };
        let at = |i: usize| list[i].as_f64().unwrap_or(0.0) as f32;
        self.positive3(name, [at(0), at(1), at(2)])
    }

    fn picture(
        &mut self,
        e: Extension<'_>,
        name: &str,
        srgb: bool,
    ) -> Result<Option<TextureRef>, Fault> {
        let Some(info) = e.get(name) else {
            return Ok(None);
        };
        let read: json::texture::Info =
            serde_json::from_value(info.clone()).map_err(|error| format!("{name}: {error}"))?;
        let extensions = info.get("extensions").and_then(Value::as_object);
        let transform = other_transform(extensions)?;
        self.texture(read.index.value(), read.tex_coord, transform.as_ref(), srgb)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use serde_json::json;

    use super::super::tests::{import, square};
    use crate::absorption;

    #[test]
    fn layers_and_bodies_keep_their_numbers() {
        let mut tree = square();
        tree["materials"] = json!([{ "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 0.75 },
            "KHR_materials_volume": {
                "thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [0.5, 0.25, 1]
            },
            "KHR_materials_dispersion": { "dispersion": 0.5 },
            "KHR_materials_diffuse_transmission": {
                "diffuseTransmissionFactor": 0.25, "diffuseTransmissionColorFactor": [1, 0.5, 0]
            },
            "KHR_materials_sheen": { "sheenColorFactor": [0.5, 0, 1], "sheenRoughnessFactor": 0.5 },
            "KHR_materials_clearcoat": { "clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.125 },
            "KHR_materials_anisotropy": { "anisotropyStrength": 0.5, "anisotropyRotation": 1.5 },
            "KHR_materials_iridescence": {
                "iridescenceFactor": 1, "iridescenceIor": 1.5, "iridescenceThicknessMaximum": 250
            },
        } }]);
        let imported = import(tree).unwrap();
        assert!(imported.warnings.is_empty(), "{:?}", imported.warnings);
        let m = &imported.scene.materials[0];
        assert_eq!(
            (m.transmission, m.is_solid, m.dispersion),
            (0.75, true, 0.5)
        );
        assert_eq!(m.absorption, absorption(Vec3::new(0.5, 0.25, 1.0), 0.5));
        assert_eq!(m.diffuse_transmission, 0.25);
        assert_eq!(m.diffuse_transmission_color, Vec3::new(1.0, 0.5, 0.0));
        assert_eq!(
            (m.sheen_color, m.sheen_roughness),
            (Vec3::new(0.5, 0.0, 1.0), 0.5)
        );
        assert_eq!((m.coat, m.coat_roughness), (0.5, 0.125));
        assert_eq!((m.anisotropy, m.anisotropy_rotation), (0.5, 1.5));
        assert_eq!((m.iridescence, m.iridescence_ior), (1.0, 1.5));
        assert_eq!(m.iridescence_thickness, [100.0, 250.0]);
    }

    #[test]
    fn numbers_out_of_range_are_brought_back_with_a_warning() {
        let mut tree = square();
        tree["materials"] = json!([{ "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 7 },
            "KHR_materials_dispersion": { "dispersion": -1 },
        } }]);
        let imported = import(tree).unwrap();
        let m = &imported.scene.materials[0];
        assert_eq!((m.transmission, m.dispersion), (1.0, 0.0));
        assert_eq!(imported.warnings.len(), 2, "{:?}", imported.warnings);
    }

    #[test]
    fn numbers_that_grow_beyond_all_bounds_are_left_out_with_a_warning() {
        let mut tree = square();
        let picture = json!({ "index": 0, "scale": 1e38 });
        tree["textures"] = json!([{}]);
        tree["materials"] = json!([{
            "emissiveFactor": [1e30, 0, 1],
            "normalTexture": picture,
            "extensions": {
                "KHR_materials_emissive_strength": { "emissiveStrength": 1e30 },
                "KHR_materials_clearcoat": { "clearcoatNormalTexture": { "index": 0, "scale": 1e300 } },
                "KHR_materials_anisotropy": { "anisotropyRotation": 1e300 },
            },
        }]);
        let imported = import(tree).unwrap();
        let m = &imported.scene.materials[0];
        assert_eq!(m.emission, Vec3::new(0.0, 0.0, 1e30));
        assert_eq!((m.normal_scale, m.coat_normal_scale), (1e6, 1.0));
        assert_eq!(m.anisotropy_rotation, 0.0);
        let warnings = imported.warnings.join("\n");
        for says in [
            "emissiveFactor times emissiveStrength is inf",
            "normalTexture.scale",
            "clearcoatNormalTexture.scale",
            "anisotropyRotation",
        ] {
            assert!(warnings.contains(says), "{says}: {warnings}");
        }
    }
}
