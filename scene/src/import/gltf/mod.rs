//! glTF 2.0. The JSON is read by the gltf crate.
//!
//! `assemble` reads as a table of contents of this folder.

mod accessor;
mod attributes;
mod container;
mod custom;
mod deform;
mod document;
mod draco;
mod environment;
mod files;
mod geometry;
mod hierarchy;
mod images;
mod indices;
mod json_text;
mod layers;
mod lights_cameras;
mod materials;
mod nodes;
mod reader;
mod referenced;
#[cfg(test)]
mod tests;

use super::budget::Budget;
use super::error::{ImportError, Warnings};
use super::format::{Format, Imported, Request};
use super::merge::make_names_unique;
use crate::input::Files;
use crate::{Environment, LightGroups, Scene};
use document::Document;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// `.gltf` and `.glb`.
#[derive(Debug)]
pub(super) struct Gltf;

impl Format for Gltf {
    fn read(&self, request: Request<'_>) -> Result<Imported, ImportError> {
        let path = request.path;
        let file = document::read(&**request.files, path).map_err(|source| ImportError::Read {
            path: path.to_owned(),
            source,
        })?;
        assemble(&parse(request.files, path, file, request.budget)?, request)
    }

    fn referenced_files(&self, files: &dyn Files, path: &Path) -> Vec<PathBuf> {
        referenced::referenced_files(files, path)
    }
}

/// The bytes of a file as a document all of whose data can be read.
fn parse(
    files: &Arc<dyn Files>,
    path: &Path,
    file: Vec<u8>,
    budget: &Arc<Budget>,
) -> Result<Document, ImportError> {
    let mut document = Document::new(files, path, file, budget)?;
    document.decompress()?;
    document.check_layout()?;
    Ok(document)
}

/// What a document adds to the scene of the request.
fn assemble(document: &Document, request: Request<'_>) -> Result<Imported, ImportError> {
    let mut warnings = Warnings::default();
    document.warn_of_extensions(&mut warnings);
    let nodes = hierarchy::resolve(document, request.placement, &mut warnings)?;
    let (mut materials, requests) = materials::read(document, &mut warnings)?;
    let (meshes, instances) = nodes::instances(
        document,
        &nodes,
        &materials,
        request.scene.instances.len(),
        &mut warnings,
    )?;
    let (lights, cameras) = nodes::lights_and_cameras(document, &nodes, &mut warnings)?;
    let (images, slots) = request
        .pictures
        .load(document, &requests, &request.scene.images)?;
    for material in &mut materials {
        for texture in material.textures_mut().into_iter().flatten() {
            texture.image = slots[texture.image as usize];
        }
    }
    let environment = if request.with_environment {
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
            light_groups: LightGroups::default(),
            environment,
        },
        warnings: warnings.into_vec(),
    })
}
