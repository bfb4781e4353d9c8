//! `[[include]]`: the contents of another file, put into the scene.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::ops::Range;

use texgen::{Diagnostic, did_you_mean};

use crate::scene::import::{Appended, Importer};
use crate::scene::look::{Include, Look, Spanned};
use crate::scene::{PunctualLight, Scene};

/// Adds what a table includes, and to `gone` the names of lights that aren't there at this moment; returns the import's warnings. On an
/// error the scene must not be used.
pub(super) fn include(
    look: &Look,
    table: &Include,
    importer: &mut Importer,
    scene: &mut Scene,
    gone: &mut BTreeSet<String>,
) -> Result<Vec<String>, Diagnostic> {
    let path = look.resolve(&table.file.value);
    let (meshes, lights) = (scene.meshes.len(), scene.lights.len());
    let added = (importer.append(scene, &path, table.transform)).map_err(|error| {
        Diagnostic::error(error.to_string()).with_label(&look.file, table.file.span.clone(), "")
    })?;
    if let Some(only) = &table.only {
        keep_only(look, only, scene, &added, lights)?;
        drop_unused_meshes(scene, meshes, added.instances.start);
    }
    let gone_lights = added.names.gone_lights.iter().filter(|(node, light)| {
        let only = table.only.as_ref();
        only.is_none_or(|only| only.iter().any(|w| w.value == *node || w.value == *light))
    });
    gone.extend(gone_lights.map(|(_, light)| light.clone()));
    let Appended {
        materials,
        renamed,
        mut warnings,
        ..
    } = added;
    match &table.name {
        Some(prefix) => prefix_names(scene, materials, &renamed, &prefix.value),
        None => warnings.extend(renamed.iter().map(|(old, new)| {
            format!(
                "material `{old}` of {} is called `{new}`, because the scene has one of its name",
                path.display()
            )
        })),
    }
    Ok(warnings)
}

/// Takes away the instances and lights whose nodes are not named; lights may be called by their own names, too.
fn keep_only(
    look: &Look,
    only: &[Spanned<String>],
    scene: &mut Scene,
    added: &Appended,
    first_light: usize,
) -> Result<(), Diagnostic> {
    let lights: Vec<PunctualLight> = scene.lights.split_off(first_light);
    let instances = scene.instances.split_off(added.instances.start);
    let (nodes, gone) = (&added.names.lights, &added.names.gone_lights);
    // What is scaled to nothing at this moment may be named as well.
    let names: HashSet<&str> = (instances.iter().map(|i| &i.name))
        .chain(lights.iter().map(|l| &l.name))
        .chain(nodes)
        .chain(&added.names.gone_meshes)
        .chain(gone.iter().flat_map(|(node, light)| [node, light]))
        .map(String::as_str)
        .collect();
    for wanted in only {
        if !names.contains(wanted.value.as_str()) {
            let mut sorted: Vec<&str> = names.iter().copied().collect();
            sorted.sort_unstable();
            let note = match did_you_mean(&wanted.value, sorted.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None if sorted.is_empty() => "it has no nodes with a mesh or a light".to_owned(),
                None => format!(
                    "it has {}",
                    sorted.into_iter().take(20).collect::<Vec<_>>().join(", ")
                ),
            };
            let message = format!(
                "the file has no node `{}` with a mesh or a light",
                wanted.value
            );
            return Err(Diagnostic::error(message)
                .with_label(&look.file, wanted.span.clone(), "")
                .with_note(note));
        }
    }
    let is_wanted = |name: &str| only.iter().any(|wanted| wanted.value == name);
    scene
        .instances
        .extend(instances.into_iter().filter(|i| is_wanted(&i.name)));
    let lights = lights.into_iter().zip(nodes);
    let lights = lights.filter(|(light, node)| is_wanted(&light.name) || is_wanted(node));
    scene.lights.extend(lights.map(|(light, _)| light));
    Ok(())
}

/// Removes the meshes from `first` on that no instance from `first_instance` on uses, as no earlier one can.
fn drop_unused_meshes(scene: &mut Scene, first: usize, first_instance: usize) {
    let instances = &mut scene.instances[first_instance..];
    let used: HashSet<u32> = instances.iter().map(|i| i.mesh).collect();
    let mut new_index = HashMap::new();
    let added = scene.meshes.split_off(first);
    for (old, mesh) in (first as u32..).zip(added) {
        if used.contains(&old) {
            new_index.insert(old, scene.meshes.len() as u32);
            scene.meshes.push(mesh);
        }
    }
    for instance in instances {
        instance.mesh = *new_index.get(&instance.mesh).unwrap_or(&instance.mesh);
    }
}

/// Calls the added materials `prefix/NAME`, NAME as in their file.
fn prefix_names(
    scene: &mut Scene,
    added: Range<usize>,
    renamed: &[(String, String)],
    prefix: &str,
) {
    let mut taken: HashSet<String> = scene.materials[..added.start]
        .iter()
        .map(|m| m.name.clone())
        .collect();
    let original: HashMap<&str, &str> = renamed
        .iter()
        .map(|(old, new)| (new.as_str(), old.as_str()))
        .collect();
    for material in &mut scene.materials[added] {
        let own = original
            .get(material.name.as_str())
            .copied()
            .unwrap_or(&material.name);
        let wanted = format!("{prefix}/{own}");
        let mut name = wanted.clone();
        let mut number = 1;
        while !taken.insert(name.clone()) {
            name = format!("{wanted}.{number:03}");
            number += 1;
        }
        material.name = name;
    }
}
