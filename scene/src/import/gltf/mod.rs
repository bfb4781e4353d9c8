//! glTF 2.0. The JSON is read by the gltf crate.
//!
//! `assemble` reads as a table of contents of this folder.

mod accessor;
mod animation;
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
#[cfg(test)]
mod moving_tests;
mod nodes;
mod reader;
mod referenced;
mod sampler;
#[cfg(test)]
mod tests;

use super::budget::Budget;
use super::error::{ImportError, Warnings};
use super::format::{Described, Format, Imported, NodeNames, Opened, Request};
use super::merge::make_names_unique;
use crate::input::Files;
use crate::{Environment, LightGroups, Motion, Scene};
use animation::Tracks;
use document::Document;
use nodes::{Kept, Stage};
use std::collections::HashSet;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// `.gltf` and `.glb`.
#[derive(Debug)]
pub(super) struct Gltf;

impl Format for Gltf {
    fn open(
        &self,
        files: &Arc<dyn Files>,
        path: &Path,
        budget: &Arc<Budget>,
        with_animations: bool,
    ) -> Result<Arc<dyn Opened>, ImportError> {
        let file = document::read(&**files, path).map_err(|source| ImportError::Read {
            path: path.to_owned(),
            source,
        })?;
        Ok(Arc::new(File {
            document: parse(files, path, file, budget, with_animations)?,
            tracks: Mutex::default(),
            kept: Kept::default(),
        }))
    }

    fn referenced_files(&self, files: &dyn Files, path: &Path) -> Vec<PathBuf> {
        referenced::referenced_files(files, path)
    }
}

/// A file that can be read at any moment.
struct File {
    document: Document,
    /// What moves it, as it was asked for last.
    tracks: Mutex<Option<(Motion, Arc<Tracks>)>>,
    kept: Kept,
}

impl fmt::Debug for File {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("File")
            .field("path", &self.document.path)
            .finish_non_exhaustive()
    }
}

impl Opened for File {
    fn read(&self, request: Request<'_>) -> Result<Imported, ImportError> {
        let tracks = self.tracks(&request.moment.motion)?;
        let kept = request.is_read_again.then_some(&self.kept);
        assemble(&self.document, &tracks, kept, request)
    }

    fn allow_again(&self) {
        self.document.allow();
    }

    fn animations(&self) -> Result<Described, ImportError> {
        animation::describe_all(&self.document)
    }
}

impl File {
    fn tracks(&self, motion: &Motion) -> Result<Arc<Tracks>, ImportError> {
        let mut known = self.tracks.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((of, tracks)) = &*known
            && of == motion
        {
            return Ok(Arc::clone(tracks));
        }
        let tracks = Arc::new(Tracks::read(&self.document, motion)?);
        *known = Some((motion.clone(), Arc::clone(&tracks)));
        Ok(tracks)
    }
}

/// The bytes of a file as a document all of whose data can be read.
fn parse(
    files: &Arc<dyn Files>,
    path: &Path,
    file: Vec<u8>,
    budget: &Arc<Budget>,
    with_animations: bool,
) -> Result<Document, ImportError> {
    let mut document = Document::new(files, path, file, budget, with_animations)?;
    document.decompress()?;
    document.check_layout()?;
    Ok(document)
}

/// What a document that is moved so adds to the scene of the request.
fn assemble(
    document: &Document,
    tracks: &Tracks,
    kept: Option<&Kept>,
    request: Request<'_>,
) -> Result<Imported, ImportError> {
    let mut warnings = Warnings::default();
    document.warn_of_unread(&mut warnings);
    let places = tracks.at(request.moment, &mut warnings);
    let nodes = hierarchy::resolve(document, request.placement, &places, &mut warnings)?;
    let (mut materials, requests) = materials::read(document, &mut warnings)?;
    let stage = Stage {
        nodes: &nodes,
        places: &places,
        kept,
    };
    let mut names = NodeNames::default();
    let (meshes, instances) = nodes::instances(
        document,
        &stage,
        &materials,
        request.scene.instances.len(),
        &mut names,
        &mut warnings,
    )?;
    let (lights, cameras) = nodes::lights_and_cameras(document, &nodes, &mut names, &mut warnings)?;
    let (images, slots) =
        (request.pictures).load(document, &requests, &request.scene.images, &mut warnings)?;
    for material in &mut materials {
        for texture in material.textures_mut().into_iter().flatten() {
            texture.image = slots[texture.image as usize];
        }
    }
    let environment = match request.with_environment {
        true => environment::of_scene(document, nodes.scene, kept, &mut warnings),
        false => Ok(Environment::default()),
    };
    let (environment, environment_problem) = match environment {
        Ok(environment) => (environment, None),
        Err(problem) => (Environment::default(), Some(problem)),
    };

    // The stand-in for missing materials is last; it stays only where something may use it.
    if materials.len() > 1 && !nodes::want_material(document, &nodes) {
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
        names,
        environment_problem,
        warnings: warnings.into_vec(),
    })
}
