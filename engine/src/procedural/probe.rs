//! The least scene that runs one texture: what tells whether a driver survives it.

use std::path::Path;

use glam::{Vec2, Vec3};
use texgen::{Diagnostics, ParameterType, SourceFile, Value};

use super::{Output, Procedural, TextureSources};
use crate::scene::look::Look;
use crate::scene::{Environment, Instance, Material, Mesh, Scene};

impl Procedural {
    /// A lit triangle whose roughness is what the texture gives.
    ///
    /// # Errors
    /// What is wrong with the texture.
    pub fn probe(texture: &SourceFile) -> Result<(Scene, Self), Diagnostics> {
        let mesh = Mesh {
            name: "probe".to_owned(),
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            uv0: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
            triangles: vec![[0, 1, 2]],
            triangle_materials: vec![0],
            ..Mesh::default()
        };
        let mut scene = Scene {
            meshes: vec![mesh],
            instances: vec![Instance {
                name: "probe".to_owned(),
                mesh: 0,
                transform: glam::Affine3A::IDENTITY,
                asset: None,
            }],
            materials: vec![Material {
                name: "probe".to_owned(),
                ..Material::default()
            }],
            environment: Environment::Constant(Vec3::ONE),
            ..Scene::default()
        };
        let mut sources = TextureSources::default();
        let file = SourceFile::new("probe", "probe.wgsl", texture.text());
        sources.insert_file(file.with_libraries(texture.libraries()));
        let look = Look::parse(Path::new(""), "[node.probe]\ntexture = \"probe\"\n")?;
        let mut procedural = Self::build(&look, &mut scene, &sources)?;
        if let Some(node) = procedural.graph.node("probe") {
            for parameter in procedural.graph.texture(node).parameters().to_vec() {
                if parameter.ty == ParameterType::Image {
                    // No image is there: the kernel survives any handle.
                    let set = procedural
                        .graph
                        .set_value(node, &parameter.name, Value::Image(0));
                    debug_assert!(set.is_ok(), "an image parameter takes an image");
                }
            }
        }
        let driven = procedural.set_output_link("probe", Output::ROUGHNESS, Some("probe.x"));
        debug_assert!(driven.is_ok(), "every texture has a first component");
        procedural.take_changes();
        Ok((scene, procedural))
    }
}
