//! A material of a look on a ball that lies on a floor, so that contact, occlusion and what is mirrored are seen.

use std::f32::consts::FRAC_PI_2;

use device::Device;
use glam::{Affine3A, Vec2, Vec3};
use texgen::{Diagnostic, Diagnostics, did_you_mean};

use super::{PreviewError, add, facing, sky, sphere, square};
use crate::procedural::{Procedural, TextureSources, expanded};
use crate::renderer::{RenderSettings, Renderer};
use crate::scene::look::{CameraLook, Look, MaterialLook};
use crate::scene::{Camera, Material, Projection, Scene};

/// Enough for light through glass to the floor, and between floor and ball.
const MAX_DEPTH: u32 = 5;
/// Half of the floor's side, metres.
const FLOOR: f32 = 6.0;

/// A material in the studio, on a ball of one metre.
#[derive(Debug, Clone)]
pub struct MaterialPreview {
    scene: Scene,
    procedural: Procedural,
}

impl MaterialPreview {
    /// Puts a material of a look into the studio, with those that it is blended of. What a scene says about it isn't there:
    /// what the look leaves open has the values of a plain material.
    ///
    /// # Errors
    /// The look has no such material; every mistake in its textures and nodes, and in the material.
    pub fn new(look: &Look, material: &str, sources: &TextureSources) -> Result<Self, Diagnostics> {
        let (look, _) = expanded(look, &**sources.files(), None)?;
        let known = || look.materials.iter().map(|table| &*table.name.value);
        if !known().any(|name| name == material) {
            let message = format!("the look has no material called `{material}`");
            let note = match did_you_mean(material, known()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("it has: {}", known().collect::<Vec<_>>().join(", ")),
            };
            let error = Diagnostic::error(message).with_label(&look.file, 0..0, "");
            return Err(error.with_note(note).into());
        }
        let alone = Look {
            environment: None,
            camera: CameraLook::default(),
            lights: Vec::new(),
            materials: with_parts(material, &look.materials),
            materialx: Vec::new(),
            includes: Vec::new(),
            ..Look::clone(&look)
        };
        let mut scene = studio(material);
        let procedural = Procedural::build(&alone, &mut scene, sources)?;
        Ok(Self { scene, procedural })
    }

    /// What is odd in the look, but not wrong.
    pub fn warnings(&self) -> &Diagnostics {
        self.procedural.warnings()
    }

    /// A renderer of the picture; `width` in pixels, it is three quarters as high.
    ///
    /// # Errors
    /// The device refuses.
    pub fn renderer(&self, device: &Device, width: u32) -> Result<Renderer, PreviewError> {
        let settings = RenderSettings {
            max_depth: MAX_DEPTH,
            ..RenderSettings::new(width, (width * 3 / 4).max(1), &camera())
        };
        Ok(Renderer::new(
            device,
            &self.scene,
            &self.procedural,
            &settings,
        )?)
    }
}

/// A material and those below its blends, in the order of the look.
fn with_parts(material: &str, all: &[MaterialLook]) -> Vec<MaterialLook> {
    let mut wanted = vec![material.to_owned()];
    let mut next = 0;
    while let Some(name) = wanted.get(next).cloned() {
        next += 1;
        let table = all.iter().find(|table| table.name.value == name);
        if let Some(blend) = table.and_then(|table| table.blend.as_ref()) {
            for part in [&blend.value.base.value, &blend.value.over.value] {
                if !wanted.contains(part) {
                    wanted.push(part.clone());
                }
            }
        }
    }
    let is_wanted = |table: &&MaterialLook| wanted.contains(&table.name.value);
    all.iter().filter(is_wanted).cloned().collect()
}

fn studio(material: &str) -> Scene {
    let mut scene = Scene {
        materials: vec![
            Material {
                name: material.to_owned(),
                metallic: 0.0,
                roughness: 0.5,
                ..Material::default()
            },
            Material {
                // No name of a look's has a line break.
                name: "floor\n".to_owned(),
                base_color: Vec3::splat(0.32).extend(1.0),
                metallic: 0.0,
                roughness: 0.7,
                ..Material::default()
            },
        ],
        environment: sky(),
        ..Scene::default()
    };
    add(
        &mut scene,
        sphere(0.5),
        Affine3A::from_translation(0.5 * Vec3::Y),
    );
    add(
        &mut scene,
        square(FLOOR),
        Affine3A::from_rotation_x(-FRAC_PI_2),
    );
    if let Some(floor) = scene.meshes.last_mut() {
        floor.triangle_materials.fill(1);
        floor.uv0 = floor
            .uv0
            .iter()
            .map(|uv| Vec2::splat(FLOOR) * *uv)
            .collect();
    }
    scene
}

fn camera() -> Camera {
    let (eye, at) = (Vec3::new(0.0, 1.5, 3.7), Vec3::new(0.0, 0.46, 0.0));
    // A camera looks along -Z.
    Camera {
        name: "preview".to_owned(),
        transform: facing(eye, eye + (eye - at)),
        projection: Projection::Perspective { y_fov: 0.36 },
        aperture_radius: 0.0,
        aperture_blades: 0,
        aperture_rotation: 0.0,
        focus_distance: 1.0,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn preview(material: &str) -> Result<MaterialPreview, String> {
        let text = "environment = { color = [1, 0, 0] }\n[light.Sun]\nangular_diameter = 1.0\n\
                    [node.n]\ntexture = \"t\"\n[material.Plain]\nbase_color = \"n\"\n\
                    [material.Other]\nroughness = 0.1\n\
                    [material.Both]\nblend = { base = \"Plain\", over = \"Other\", mask = 0.5 }\n";
        let look = Look::parse(Path::new("l.toml"), text).unwrap_or_else(|e| panic!("{e}"));
        let mut sources = TextureSources::default();
        sources.insert("t", "fn userProc() -> vec3f { return vec3f(0.5); }");
        MaterialPreview::new(&look, material, &sources).map_err(|e| e.render())
    }

    #[test]
    fn materials_come_with_what_they_are_blended_of() {
        let plain = preview("Plain").unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(plain.scene.materials.len(), 2);
        let both = preview("Both").unwrap_or_else(|e| panic!("{e}"));
        assert!(both.procedural.is_procedural(0));
        let error = preview("Plane").expect_err("no such material");
        assert!(error.contains("did you mean `Plain`?"), "{error}");
    }
}
