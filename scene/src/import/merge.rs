//! Puts what a file adds into a scene: indices are shifted, names of materials stay unique.

use super::format::{Imported, NodeNames};
use crate::import::place::MAX_INSTANCES;
use crate::{Instance, Material, Scene};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// What [`append`](super::append) added to a scene.
#[derive(Debug)]
pub struct Appended {
    /// The new materials in `Scene::materials`.
    pub materials: Range<usize>,
    /// The new instances in `Scene::instances`.
    pub instances: Range<usize>,
    /// Materials that got another name, because theirs was taken: (name in the file, name in the scene).
    pub renamed: Vec<(String, String)>,
    /// What nodes of the file are called; of its lights, which are the last ones in `Scene::lights`, in their order.
    pub names: NodeNames,
    /// Sentences about what is shown differently from what the file says.
    pub warnings: Vec<String>,
}

pub(super) fn merge(scene: &mut Scene, imported: Imported) -> Appended {
    let Imported {
        scene: mut added,
        names,
        warnings,
        ..
    } = imported;
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
    make_room(&mut scene.instances, added.instances.len());
    scene.instances.append(&mut added.instances);
    scene.materials.append(&mut added.materials);
    scene.images.append(&mut added.images);
    scene.lights.append(&mut added.lights);
    Appended {
        materials: first_material as usize..scene.materials.len(),
        instances: first_instance..scene.instances.len(),
        renamed,
        names,
        warnings,
    }
}

/// Keeps the first of equal names and numbers the others. Returns (old, new) of what was renamed.
pub(super) fn make_names_unique(
    materials: &mut [Material],
    taken: &HashSet<String>,
) -> Vec<(String, String)> {
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

/// Room for so many more: twice as much as there was where that is needed, as lists grow, but not for more than there may be.
fn make_room(instances: &mut Vec<Instance>, more: usize) {
    let (count, room) = (instances.len(), instances.capacity());
    if count + more > room {
        let wanted = (2 * room).min(MAX_INSTANCES).max(count + more);
        instances.reserve_exact(wanted - count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn made_up_names_avoid_those_of_the_file() {
        let named = |name: &str| Material {
            name: name.into(),
            ..Material::default()
        };
        let mut materials = [named("a"), named("a"), named("a.001"), named("a")];
        make_names_unique(&mut materials, &HashSet::new());
        let names: Vec<&str> = materials
            .iter()
            .map(|material| material.name.as_str())
            .collect();
        assert_eq!(names, ["a", "a.002", "a.001", "a.003"]);
    }
}
