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
mod json_text;
mod layers;
mod lights_cameras;
mod materials;
mod nodes;
mod panorama;
mod referenced;
mod split;
mod tangents;
mod triangles;

pub use environment::load_environment_image;
pub use error::ImportError;
pub(crate) use images::load_picture;
pub use lights_cameras::default_camera;
pub use referenced::referenced_files;

use super::{Environment, Image, Material, Mesh, Scene};
use budget::Budget;
use document::Document;
use error::Warnings;
use glam::{Affine3A, DAffine3, DMat3};
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

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
    Importer::new().load(path)
}

/// Adds the contents of a `.gltf` or `.glb` to a scene; see [`Importer::append`].
///
/// # Errors
/// As [`load`]; the scene is not changed then.
pub fn append(
    scene: &mut Scene,
    path: &Path,
    placement: Affine3A,
) -> Result<Appended, ImportError> {
    Importer::new().add(scene, path, placement)
}

/// Reads the files of one scene. What all of them together take is bounded, and a picture that several of them show is
/// there once.
#[derive(Debug)]
pub struct Importer {
    budget: Arc<Budget>,
    /// Pictures that the scene has, and whether they are read as sRGB.
    images: HashMap<(images::Key, bool), u32>,
    held: Held,
}

/// The meshes and instances of the scene that are counted, and what they take.
#[derive(Debug, Default)]
struct Held {
    meshes: usize,
    instances: usize,
    bytes: u64,
}

impl Default for Importer {
    fn default() -> Self {
        Self::new()
    }
}

impl Importer {
    /// For a new scene.
    pub fn new() -> Self {
        Self {
            budget: Arc::new(Budget::for_geometry()),
            images: HashMap::new(),
            held: Held::default(),
        }
    }

    /// The first file of the scene; as the function [`load`].
    ///
    /// # Errors
    /// As [`load`].
    pub fn load(&mut self, path: &Path) -> Result<Imported, ImportError> {
        let document = Document::open(path, &self.budget)?;
        self.assemble(&document, DAffine3::IDENTITY, &Scene::default(), true)
    }

    /// Adds the contents of a `.gltf` or `.glb` to the scene, as if its root nodes were children of a node with the
    /// transform `placement`. Its cameras and its environment are not taken; the scene keeps its own.
    ///
    /// Names of materials stay unique: a second `Steel` becomes `Steel.001`.
    ///
    /// # Errors
    /// As [`load`], and where the scene becomes too large; it is not changed then.
    pub fn append(
        &mut self,
        scene: &mut Scene,
        path: &Path,
        placement: Affine3A,
    ) -> Result<Appended, ImportError> {
        // What was taken while decoding, or by what was left out later, is free again.
        self.held.count(scene);
        self.budget.hold(self.held.bytes);
        self.add(scene, path, placement)
    }

    fn add(
        &mut self,
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
        let document = Document::open(path, &self.budget)?;
        let Imported {
            scene: added,
            warnings,
        } = self.assemble(&document, world, scene, false)?;
        Ok(merge(scene, added, warnings))
    }

    /// What a file adds to `scene`. Its materials refer to images by where they will stand in `Scene::images`.
    fn assemble(
        &mut self,
        document: &Document,
        placement: DAffine3,
        scene: &Scene,
        with_environment: bool,
    ) -> Result<Imported, ImportError> {
        let mut warnings = Warnings::default();
        document.warn_of_extensions(&mut warnings);
        let nodes = hierarchy::resolve(document, placement, &mut warnings)?;
        let (mut materials, requests) = materials::read(document, &mut warnings)?;
        let (meshes, instances) = nodes::instances(
            document,
            &nodes,
            &materials,
            scene.instances.len(),
            &mut warnings,
        )?;
        let (lights, cameras) = nodes::lights_and_cameras(document, &nodes, &mut warnings)?;
        let (images, slots) = self.images(document, &requests, scene)?;
        for material in &mut materials {
            for texture in material.textures_mut().into_iter().flatten() {
                texture.image = slots[texture.image as usize];
            }
        }
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

    /// The requested images that the scene doesn't have yet, and where each of the requested ones will stand.
    fn images(
        &mut self,
        document: &Document,
        requests: &[(usize, bool)],
        scene: &Scene,
    ) -> Result<(Vec<Image>, Vec<u32>), ImportError> {
        let (mut missing, mut added, mut slots) = (Vec::new(), Vec::new(), Vec::new());
        for &(index, srgb) in requests {
            let key = (images::key(document, index), srgb);
            let next = (scene.images.len() + missing.len()) as u32;
            let slot = self.images.get(&key).copied().unwrap_or_else(|| {
                missing.push((index, srgb));
                added.push((key, next));
                next
            });
            slots.push(slot);
        }
        let images = images::load(document, &missing, &scene.images)?;
        self.images.extend(added);
        Ok((images, slots))
    }
}

impl Held {
    /// Counts what the scene has in addition.
    fn count(&mut self, scene: &Scene) {
        let mesh = |mesh: &Mesh| {
            let vertices = size_of_val(&*mesh.positions)
                + size_of_val(&*mesh.normals)
                + size_of_val(&*mesh.tangents)
                + size_of_val(&*mesh.uv0)
                + size_of_val(&*mesh.uv1)
                + size_of_val(&*mesh.colors);
            let custom = mesh.custom.iter().map(|c| size_of_val(&*c.values));
            let triangles = size_of_val(&*mesh.triangles) + size_of_val(&*mesh.triangle_materials);
            (size_of::<Mesh>() + vertices + custom.sum::<usize>() + triangles) as u64
        };
        let meshes = scene.meshes.iter().skip(self.meshes).map(mesh);
        let instances = scene.instances.iter().skip(self.instances);
        self.bytes += meshes.sum::<u64>() + instances.map(|i| i.name.len() as u64).sum::<u64>();
        (self.meshes, self.instances) = (scene.meshes.len(), scene.instances.len());
    }
}

fn merge(scene: &mut Scene, mut added: Scene, warnings: Vec<String>) -> Appended {
    let first_mesh = scene.meshes.len() as u32;
    let first_material = scene.materials.len() as u32;
    for mesh in &mut added.meshes {
        mesh.triangle_materials
            .iter_mut()
            .for_each(|material| *material += first_material);
    }
    for instance in &mut added.instances {
        instance.mesh += first_mesh;
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
