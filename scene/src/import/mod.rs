//! Files to a [`Scene`].
//!
//! Files are foreign input: every index, offset and length in them is checked before it is used, memory is bounded by the
//! size of the files, and no path of a file leads to a panic. What can't be rendered is left out with a warning; what
//! would change the picture beyond recognition is an error.
//!
//! A format is a folder that implements `Format`, and a row of [`FORMATS`]. What formats have in common stands beside the
//! folders: pictures (each decoded once), meshes (triangles that can be rendered, normals, tangents), their places, budgets of
//! memory, errors.

mod budget;
mod environment;
mod error;
mod format;
mod gltf;
mod merge;
mod mesh;
mod panorama;
mod pictures;
mod place;

pub use environment::{environment_image_size, load_environment_image};
pub use error::ImportError;
pub use format::{Imported, NodeNames};
pub use merge::Appended;
pub use mesh::tangents::give_tangents;
pub use pictures::load_picture;

use crate::input::{Disk, Files};
use crate::{Animation, Mesh, Moment, Motion, Scene};
use budget::Budget;
use format::{Described, Format, Opened, Request};
use glam::{Affine3A, DAffine3, DMat3};
use merge::merge;
use pictures::Pictures;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A format of scene files.
#[derive(Debug)]
pub struct SceneFormat {
    /// What people call it.
    pub name: &'static str,
    /// How names of such files end, without the dot, in small letters.
    pub endings: &'static [&'static str],
    /// What is taken from them, for people.
    pub help: &'static str,
    reader: &'static dyn Format,
}

/// All formats of scene files. What names none of them may still be of the first, and says so itself.
pub static FORMATS: [SceneFormat; 1] = [SceneFormat {
    name: "glTF 2.0",
    endings: &["gltf", "glb"],
    help: "meshes, instances, materials with their textures, lights, cameras, animations; the default scene",
    reader: &gltf::Gltf,
}];

/// The format that a file's name stands for; `None` where it isn't known.
fn format_of(path: &Path) -> Option<&'static SceneFormat> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    let is_of = |format: &&SceneFormat| format.endings.contains(&ending.as_str());
    FORMATS.iter().find(is_of)
}

fn reader_of(path: &Path) -> &'static dyn Format {
    format_of(path).unwrap_or(&FORMATS[0]).reader
}

/// Whether a file is a scene by its name.
pub fn is_scene(path: &Path) -> bool {
    format_of(path).is_some()
}

/// What a scene file may be, for people: `a glTF 2.0 file (.gltf or .glb)`.
pub fn known_formats() -> String {
    let shown = |format: &SceneFormat| {
        let endings: Vec<_> = format.endings.iter().map(|e| format!(".{e}")).collect();
        format!("a {} file ({})", format.name, endings.join(" or "))
    };
    FORMATS.iter().map(shown).collect::<Vec<_>>().join(" or ")
}

/// The files beside a scene file that it names, for those who watch them; none where it can't be understood. Nothing of
/// it is checked: importing does that.
pub fn referenced_files(files: &dyn Files, path: &Path) -> Vec<PathBuf> {
    reader_of(path).referenced_files(files, path)
}

/// The animations of a scene file of the disk.
///
/// # Errors
/// As [`load`]; an animation that makes no sense.
pub fn animations(path: &Path) -> Result<Vec<Animation>, ImportError> {
    let Described {
        animations,
        problem,
    } = Importer::new().described(path)?;
    match problem {
        Some(problem) => Err(problem),
        None => Ok(animations),
    }
}

/// Reads a scene file with all its buffers and pictures from the disk: the default scene, at rest. [`Importer::from_files`] has
/// other files.
///
/// A file without triangles gives a scene without instances; that is not an error here. Nor is an environment that can't be read:
/// it is black, with a warning.
///
/// # Errors
/// Where a file is missing, damaged, needs an extension that isn't supported, or is larger than memory allows. The
/// text of the error names the file, the place in it and the remedy.
pub fn load(path: &Path) -> Result<Imported, ImportError> {
    let mut imported = Importer::new().load(path)?;
    let problem = imported.environment_problem.take();
    (imported.warnings)
        .extend(problem.map(|problem| format!("{problem}; the environment is black")));
    Ok(imported)
}

/// Adds the contents of a scene file to a scene; see [`Importer::append`].
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
///
/// A scene that moves is read again and again: [`Self::begin`] begins it anew at another [`Moment`]. Files stay open then, pictures
/// are decoded the first time only (the scenes that follow have none: they are those of the first), and meshes that don't bend are
/// built once.
#[derive(Debug)]
pub struct Importer {
    files: Arc<dyn Files>,
    budget: Arc<Budget>,
    pictures: Pictures,
    held: Held,
    moment: Moment,
    /// Files that stay open; `None` where each is read once.
    open: Option<HashMap<PathBuf, Kept>>,
}

/// A file that stays open.
#[derive(Debug)]
struct Kept {
    file: Arc<dyn Opened>,
    /// How often the scene of now has it, and the most that one has had it.
    uses: u32,
    most_uses: u32,
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
    /// For a new scene, from the disk.
    pub fn new() -> Self {
        Self::from_files(Arc::new(Disk))
    }

    /// For a new scene, from files of one's own.
    pub fn from_files(files: Arc<dyn Files>) -> Self {
        Self {
            files,
            budget: Arc::new(Budget::for_geometry()),
            pictures: Pictures::default(),
            held: Held::default(),
            moment: Moment::default(),
            open: None,
        }
    }

    /// The scene is read as it is at this moment.
    pub fn look_at(&mut self, moment: Moment) {
        self.moment = moment;
    }

    /// Begins the same scene at another moment.
    pub fn begin(&mut self, moment: Moment) {
        self.moment = moment;
        self.held = Held::default();
        if let Some(open) = &mut self.open {
            self.budget.hold(0);
            open.values_mut().for_each(|kept| kept.uses = 0);
        }
        self.open.get_or_insert_default();
    }

    /// The animations of a file. One that makes no sense has a name alone: what is wrong with it is told by who moves the scene by
    /// it.
    ///
    /// # Errors
    /// As [`load`].
    pub fn animations(&mut self, path: &Path) -> Result<Vec<Animation>, ImportError> {
        Ok(self.described(path)?.animations)
    }

    fn described(&mut self, path: &Path) -> Result<Described, ImportError> {
        let uses = self
            .open
            .as_ref()
            .and_then(|open| Some(open.get(path)?.uses));
        let described = self.opened(path, true)?.animations();
        // Looked at, it isn't added to the scene.
        if let Some(kept) = self.open.as_mut().and_then(|open| open.get_mut(path)) {
            kept.uses = uses.unwrap_or(0);
        }
        described
    }

    /// A file, which stays open where it will be read again.
    fn opened(&mut self, path: &Path, moves: bool) -> Result<Arc<dyn Opened>, ImportError> {
        let moves = moves || self.open.is_some();
        let open = || reader_of(path).open(&self.files, path, &self.budget, moves);
        let Some(kept) = &mut self.open else {
            return open();
        };
        if let Some(kept) = kept.get_mut(path) {
            kept.uses += 1;
            if kept.uses > kept.most_uses {
                kept.most_uses = kept.uses;
                // The first use was allowed for when it was opened.
                if kept.uses > 1 {
                    kept.file.allow_again();
                }
            }
            return Ok(Arc::clone(&kept.file));
        }
        let file = open()?;
        let (uses, most_uses) = (1, 1);
        kept.insert(
            path.to_owned(),
            Kept {
                file: Arc::clone(&file),
                uses,
                most_uses,
            },
        );
        Ok(file)
    }

    /// The first file of the scene; as the function [`load`], but that it is left to the caller what an environment that can't be
    /// read is: see [`Imported::environment_problem`].
    ///
    /// # Errors
    /// As [`load`].
    pub fn load(&mut self, path: &Path) -> Result<Imported, ImportError> {
        self.opened(path, self.moment.motion != Motion::Rest)?
            .read(Request {
                placement: DAffine3::IDENTITY,
                scene: &Scene::default(),
                with_environment: true,
                moment: &self.moment,
                is_read_again: self.open.is_some(),
                pictures: &mut self.pictures,
            })
    }

    /// Adds the contents of a file to the scene, as if its root nodes were children of a node with the transform
    /// `placement`. Its cameras and its environment are not taken; the scene keeps its own.
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
        let imported = self
            .opened(path, self.moment.motion != Motion::Rest)?
            .read(Request {
                placement: world,
                scene,
                with_environment: false,
                moment: &self.moment,
                is_read_again: self.open.is_some(),
                pictures: &mut self.pictures,
            })?;
        Ok(merge(scene, imported))
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
