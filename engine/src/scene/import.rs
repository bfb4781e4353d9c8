//! glTF 2.0 to [`Scene`].
//!
//! Files are foreign input. The JSON is read by the gltf crate; every index, offset and length in it is checked here
//! before it is used, memory is bounded by the size of the file, and no path of a file leads to a panic. What can't
//! be rendered is left out with a warning; what would change the picture beyond recognition is an error.
//!
//! `assemble` reads as a table of contents of this folder.

mod accessor;
mod budget;
mod container;
mod custom;
mod deform;
mod document;
mod draco;
mod environment;
mod error;
mod files;
mod geometry;
mod hierarchy;
mod images;
mod join;
mod layers;
mod lights_cameras;
mod materials;
mod nodes;
mod referenced;
mod split;
mod tangents;
mod triangles;

pub use environment::load_environment_image;
pub use error::ImportError;
pub(crate) use images::load_picture;
pub use lights_cameras::default_camera;
pub use referenced::referenced_files;

use super::{Environment, Material, Scene};
use document::Document;
use error::Warnings;
use glam::{Affine3A, DAffine3, DMat3};
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::path::Path;

/// A scene and what the user should know about it.
#[derive(Debug)]
pub struct Imported {
    /// What was read.
    pub scene: Scene,
    /// Sentences about what is shown differently from what the file says.
    pub warnings: Vec<String>,
}

/// What [`append`] added to a scene.
#[derive(Debug)]
pub struct Appended {
    /// The new materials in `Scene::materials`.
    pub materials: Range<usize>,
    /// The new instances in `Scene::instances`.
    pub instances: Range<usize>,
    /// Materials that got another name, because theirs was taken: (name in the file, name in the scene).
    pub renamed: Vec<(String, String)>,
    /// Sentences about what is shown differently from what the file says.
    pub warnings: Vec<String>,
}

/// Reads a `.gltf` or `.glb` with all its buffers and pictures: the default scene, at rest.
///
/// A file without triangles gives a scene without instances; that is not an error here.
///
/// # Errors
/// Where a file is missing, damaged, needs an extension that isn't supported, or is larger than memory allows. The
/// text of the error names the file, the place in it and the remedy.
pub fn load(path: &Path) -> Result<Imported, ImportError> {
    assemble(&Document::open(path)?, DAffine3::IDENTITY, true)
}

/// Adds the contents of a `.gltf` or `.glb` to a scene, as if its root nodes were children of a node with the
/// transform `placement`. Its cameras and its environment are not taken; the scene keeps its own.
///
/// Names of materials stay unique: a second `Steel` becomes `Steel.001`.
///
/// # Errors
/// As [`load`]; the scene is not changed then.
pub fn append(
    scene: &mut Scene,
    path: &Path,
    placement: Affine3A,
) -> Result<Appended, ImportError> {
    let world = DAffine3 {
        matrix3: DMat3::from_cols(
            placement.matrix3.x_axis.as_dvec3(),
            placement.matrix3.y_axis.as_dvec3(),
            placement.matrix3.z_axis.as_dvec3(),
        ),
        translation: placement.translation.as_dvec3(),
    };
    let Imported {
        scene: added,
        warnings,
    } = assemble(&Document::open(path)?, world, false)?;
    Ok(merge(scene, added, warnings))
}

fn assemble(
    document: &Document,
    placement: DAffine3,
    with_environment: bool,
) -> Result<Imported, ImportError> {
    let mut warnings = Warnings::default();
    document.warn_of_extensions(&mut warnings);
    let nodes = hierarchy::resolve(document, placement, &mut warnings)?;
    let (mut materials, requests) = materials::read(document, &mut warnings)?;
    let (meshes, instances) = nodes::instances(document, &nodes, &materials, &mut warnings)?;
    let (lights, cameras) = nodes::lights_and_cameras(document, &nodes, &mut warnings)?;
    let images = images::load(document, &requests)?;
    let environment = if with_environment {
        environment::of_scene(document, nodes.scene, &mut warnings)?
    } else {
        Environment::default()
    };

    // The stand-in for missing materials is last; it stays only where something uses it.
    let stand_in = materials.len() as u32 - 1;
    if !meshes
        .iter()
        .any(|mesh| mesh.triangle_materials.contains(&stand_in))
        && stand_in > 0
    {
        materials.pop();
    }
    make_names_unique(&mut materials, &HashSet::new());
    Ok(Imported {
        scene: Scene {
            meshes,
            instances,
            materials,
            images,
            lights,
            cameras,
            environment,
        },
        warnings: warnings.into_vec(),
    })
}

fn merge(scene: &mut Scene, mut added: Scene, warnings: Vec<String>) -> Appended {
    let first_mesh = scene.meshes.len() as u32;
    let first_material = scene.materials.len() as u32;
    let first_image = scene.images.len() as u32;
    for mesh in &mut added.meshes {
        mesh.triangle_materials
            .iter_mut()
            .for_each(|material| *material += first_material);
    }
    for instance in &mut added.instances {
        instance.mesh += first_mesh;
    }
    for material in &mut added.materials {
        for texture in material.textures_mut().into_iter().flatten() {
            texture.image += first_image;
        }
    }
    let taken = scene
        .materials
        .iter()
        .map(|material| material.name.clone())
        .collect();
    let renamed = make_names_unique(&mut added.materials, &taken);
    let first_instance = scene.instances.len();
    scene.meshes.append(&mut added.meshes);
    scene.instances.append(&mut added.instances);
    scene.materials.append(&mut added.materials);
    scene.images.append(&mut added.images);
    scene.lights.append(&mut added.lights);
    Appended {
        materials: first_material as usize..scene.materials.len(),
        instances: first_instance..scene.instances.len(),
        renamed,
        warnings,
    }
}

/// Keeps the first of equal names and numbers the others. Returns (old, new) of what was renamed.
fn make_names_unique(materials: &mut [Material], taken: &HashSet<String>) -> Vec<(String, String)> {
    let mut names = taken.clone();
    // All names of the file come before made-up ones, so that a real `Steel.001` keeps its own.
    let own: HashSet<String> = materials
        .iter()
        .map(|material| material.name.clone())
        .collect();
    let mut next: HashMap<String, u32> = HashMap::new();
    let mut renamed = Vec::new();
    for material in materials {
        if names.insert(material.name.clone()) {
            continue;
        }
        let counter = next.entry(material.name.clone()).or_insert(0);
        let unique = loop {
            *counter += 1;
            let candidate = format!("{}.{counter:03}", material.name);
            if !names.contains(&candidate) && !own.contains(&candidate) {
                break candidate;
            }
        };
        names.insert(unique.clone());
        let old = std::mem::replace(&mut material.name, unique.clone());
        renamed.push((old, unique));
    }
    renamed
}

#[cfg(test)]
mod tests;
