//! A scene over time: files are read once, and the scene is made of them at one moment after the other.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use texgen::SourceFile;

use crate::procedural::{Procedural, TextureSources};
use crate::scene::import::{Imported, Importer};
use crate::scene::look::{Look, LookError};
use crate::scene::{
    Animation, Camera, Image, Instance, Material, Mesh, Moment, Motion, Scene, default_camera,
};
use crate::system::Assets;

use super::{Applied, EnvironmentMaker, LoadError, Loaded, apply, check_environment, finish};

/// A scene with its look at any moment. What is the same at all of them (pictures, meshes that don't bend, textures) is read and
/// built for the first one.
#[derive(Debug)]
pub struct Timeline {
    files: Arc<dyn Assets>,
    path: PathBuf,
    /// Path and text of the look.
    look: Option<(PathBuf, String)>,
    textures: Vec<PathBuf>,
    importer: Importer,
    sources: Option<TextureSources>,
    environments: EnvironmentMaker,
    former: Option<Former>,
    /// Of the scene's files.
    images: Option<Vec<Image>>,
    /// The view of a scene without cameras, which must not follow what moves.
    still: Option<Camera>,
}

/// What the moments before this one have left.
#[derive(Debug)]
struct Former {
    look: Option<Look>,
    /// Materials of the scene's files.
    names: Vec<String>,
    /// With the look.
    materials: Vec<Material>,
    images: Vec<Image>,
    procedural: Procedural,
}

/// A scene that is complete but for what a look says of materials.
struct Staged {
    scene: Scene,
    look: Option<Look>,
    applied: Applied,
    warnings: Vec<String>,
}

impl Timeline {
    /// A scene at `path`, with a look of this text that lies at a path, and folders with textures. Nothing is read yet.
    pub fn new(
        files: &Arc<dyn Assets>,
        path: &Path,
        look: Option<(PathBuf, String)>,
        textures: &[PathBuf],
    ) -> Self {
        Self {
            files: Arc::clone(files),
            path: path.to_owned(),
            look,
            textures: textures.to_vec(),
            importer: Importer::from_files(files.clone()),
            sources: None,
            environments: EnvironmentMaker::default(),
            former: None,
            images: None,
            still: None,
        }
    }

    /// The animations of the scene's own file; of those that make no sense the names alone.
    ///
    /// # Errors
    /// As [`super::load`].
    pub fn animations(&mut self) -> Result<Vec<Animation>, LoadError> {
        Ok(self.importer.animations(&self.path)?)
    }

    /// The scene at the one moment that is wanted.
    ///
    /// # Errors
    /// As [`super::load`].
    pub fn once(mut self, moment: &Moment) -> Result<Loaded, LoadError> {
        if moment.motion != Motion::Rest {
            return self.at(moment);
        }
        self.importer.look_at(moment.clone());
        self.read(moment, false)
    }

    /// The scene at a moment. It is as if it were the only one. A scene without cameras is seen as it is seen at rest.
    ///
    /// # Errors
    /// As [`super::load`].
    pub fn at(&mut self, moment: &Moment) -> Result<Loaded, LoadError> {
        if moment.motion != Motion::Rest && self.still.is_none() {
            self.importer.begin(Moment::default());
            let rest = self.stage(&Moment::default(), None)?.scene;
            self.still = Some(default_camera(&rest));
        }
        self.importer.begin(moment.clone());
        self.read(moment, true)
    }

    fn read(&mut self, moment: &Moment, is_read_again: bool) -> Result<Loaded, LoadError> {
        let still = self.still.clone();
        let Staged {
            mut scene,
            look,
            applied,
            warnings,
        } = self.stage(moment, still.as_ref())?;
        if scene.instances.is_empty() {
            if moment.motion == Motion::Rest {
                return Err(LoadError::Empty {
                    path: self.path.clone(),
                });
            }
            place_nothing(&mut scene);
        }
        let names = names(&scene);
        let procedural = match &self.former {
            Some(former) if former.fits(&look, &names) => {
                scene.materials.clone_from(&former.materials);
                scene.images.clone_from(&former.images);
                former.procedural.clone()
            }
            _ => self.build(look.as_ref(), &mut scene)?,
        };
        if is_read_again {
            self.former = Some(Former {
                look: look.clone(),
                names,
                materials: scene.materials.clone(),
                images: scene.images.clone(),
                procedural: procedural.clone(),
            });
        }
        Ok(finish(scene, procedural, applied, look, warnings))
    }

    /// The scene with all that a look says of it but for materials.
    fn stage(&mut self, moment: &Moment, still: Option<&Camera>) -> Result<Staged, LoadError> {
        let look = match &self.look {
            Some((path, text)) => {
                Some(Look::parse_at(path, text, moment.seconds).map_err(LookError::from)?)
            }
            None => None,
        };
        let mut imported = self.files.scene(&mut self.importer, &self.path)?;
        check_environment(&mut imported, look.as_ref())?;
        let applied = match &look {
            Some(look) => apply(
                &*self.files,
                look,
                &mut self.importer,
                &mut self.environments,
                &mut imported,
                still,
            )?,
            None => Applied::nothing(&imported, still),
        };
        let Imported {
            mut scene,
            warnings,
            ..
        } = imported;
        match &self.images {
            // They were decoded when the files were read first.
            Some(images) => scene.images.clone_from(images),
            None => self.images = Some(scene.images.clone()),
        }
        Ok(Staged {
            scene,
            look,
            applied,
            warnings,
        })
    }

    /// Brings a look to the materials of a scene.
    fn build(&mut self, look: Option<&Look>, scene: &mut Scene) -> Result<Procedural, LoadError> {
        let nothing = Look::empty(Path::new(""), SourceFile::new("look", "", ""));
        let look = look.unwrap_or(&nothing);
        let sources = match self.sources.take() {
            Some(sources) => sources,
            None if !look.nodes.is_empty() || !look.materialx.is_empty() => {
                TextureSources::search_from(self.files.clone(), &self.textures)?
            }
            None => TextureSources::default(),
        };
        let built = Procedural::build(look, scene, self.sources.insert(sources));
        Ok(built.map_err(LookError::from)?)
    }
}

impl Former {
    /// Whether materials and textures are those of this look, too.
    fn fits(&self, look: &Option<Look>, names: &[String]) -> bool {
        let is_same = match (&self.look, look) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                // Rectangles among the lights have materials, too.
                (&a.nodes, &a.materials, &a.ao, &a.lights)
                    == (&b.nodes, &b.materials, &b.ao, &b.lights)
            }
            _ => false,
        };
        is_same && self.names == names
    }
}

fn names(scene: &Scene) -> Vec<String> {
    let materials = scene.materials.iter();
    materials.map(|material| material.name.clone()).collect()
}

/// What a scene has at a moment when all that moves has no size, as things have that aren't to be seen then: a triangle without an area,
/// which no ray meets.
fn place_nothing(scene: &mut Scene) {
    if scene.materials.is_empty() {
        scene.materials.push(Material::default());
    }
    let mesh = scene.meshes.len() as u32;
    scene.meshes.push(Mesh {
        name: "nothing".to_owned(),
        positions: [0.0, 1.0, 2.0].map(|x| Vec3::X * x).into(),
        normals: vec![Vec3::Y; 3],
        triangles: vec![[0, 1, 2]],
        triangle_materials: vec![0],
        ..Mesh::default()
    });
    scene.instances.push(Instance {
        name: "nothing".to_owned(),
        mesh,
        transform: Affine3A::IDENTITY,
        asset: None,
    });
}
