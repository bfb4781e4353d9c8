//! Everything that is rendered, from files: a glTF scene, a look and user textures become a [`Loaded`].
//!
//! This is the order in which the readers are called, and nothing more. No GPU here.

mod camera;
mod files;
mod groups;
mod include;
mod light;
mod stand_in;
mod timeline;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use texgen::{Diagnostic, Diagnostics, SourceFile, did_you_mean};

use crate::procedural::traits::BRIGHTEST_DISPLAY;
use crate::procedural::{Procedural, SourcesError, TextureSources};
use crate::scene::import::{self, ImportError, Imported, Importer};
use crate::scene::look::{EnvironmentLook, Look, LookError, Spanned};
use crate::scene::{
    Camera, Environment, LightSource, Material, PunctualLight, Scene, default_camera,
};
use crate::system::{Assets, Disk, Files};

pub use files::{files, files_from};
pub(crate) use light::{change as change_light, own as own_light};
pub use stand_in::StandIn;
pub use timeline::Timeline;

/// After so many includes that can't be read the others aren't tried.
const MAX_BAD_INCLUDES: usize = 10;

/// A scene ready to be uploaded.
#[derive(Debug)]
pub struct Loaded {
    /// The glTF scene with includes, environment and material constants of the look.
    pub scene: Scene,
    /// The texture graph; empty without a look.
    pub procedural: Procedural,
    /// The look's camera; without one the first camera of the file, or a view of the whole scene.
    pub camera: Camera,
    /// The look itself, where there is one.
    pub look: Option<Look>,
    /// Lights as they are without the look's `[light.NAME]`.
    pub given_lights: Vec<PunctualLight>,
    /// The scene's file has light from all directions of its own.
    pub has_given_environment: bool,
    /// Its files have lights that are scaled to nothing at this moment: it is a dark one, and nothing stands in for them.
    pub has_gone_lights: bool,
    /// What is shown differently from what the files say, and what is odd in the look or its textures.
    pub warnings: Diagnostics,
}

/// Why a scene can't be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The scene itself.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The look, or something it names.
    #[error(transparent)]
    Look(#[from] LookError),
    /// The textures directories.
    #[error(transparent)]
    Textures(#[from] SourcesError),
    /// Nothing to render.
    #[error("{} has no triangles: there is nothing to render; export it with the meshes that nodes of its scene place", path.display())]
    Empty {
        /// The scene.
        path: PathBuf,
    },
    /// No camera of that name.
    #[error("the scene has no camera called `{name}`: {remedy}")]
    UnknownCamera {
        /// As asked for.
        name: String,
        /// What there is.
        remedy: String,
    },
}

/// Reads a glTF scene, the look beside it, and the textures that the look uses from some directories (where two
/// have one of the same name, the earlier one's) or of the standard ones.
///
/// # Errors
/// Whatever is wrong with the files, all mistakes of the look at once, and a scene without triangles.
pub fn load(scene: &Path, look: Option<&Path>, textures: &[PathBuf]) -> Result<Loaded, LoadError> {
    // First what is small, so that a mistake in the look doesn't wait for a large scene.
    let look = look.map(Look::load).transpose()?;
    load_with(scene, look, textures)
}

/// As [`load`], with a look that is at hand.
///
/// # Errors
/// As [`load`].
pub fn load_with(
    path: &Path,
    look: Option<Look>,
    textures: &[PathBuf],
) -> Result<Loaded, LoadError> {
    let disk: Arc<dyn Assets> = Arc::new(Disk);
    load_from(&disk, path, look, textures)
}

/// As [`load_with`], from files of one's own: scene and textures, and what they and the look name (buffers, pictures, includes).
///
/// # Errors
/// As [`load`].
pub fn load_from(
    files: &Arc<dyn Assets>,
    path: &Path,
    look: Option<Look>,
    textures: &[PathBuf],
) -> Result<Loaded, LoadError> {
    let has_textures = |look: &Look| !look.nodes.is_empty() || !look.materialx.is_empty();
    let uses_textures = look.as_ref().is_some_and(has_textures);
    let sources = if uses_textures {
        TextureSources::search_from(files.clone(), textures)?
    } else {
        TextureSources::default()
    };
    let mut importer = Importer::from_files(files.clone());
    let mut imported = files.scene(&mut importer, path)?;
    check_environment(&mut imported, look.as_ref())?;

    let mut environments = EnvironmentMaker::default();
    let applied = match &look {
        Some(look) => apply(
            &**files,
            look,
            &mut importer,
            &mut environments,
            &mut imported,
            None,
        )?,
        None => Applied::nothing(&imported, None),
    };
    let Imported {
        mut scene,
        warnings,
        ..
    } = imported;
    if scene.instances.is_empty() {
        return Err(LoadError::Empty {
            path: path.to_owned(),
        });
    }
    let nothing = Look::empty(Path::new(""), SourceFile::new("look", "", ""));
    let procedural = Procedural::build(look.as_ref().unwrap_or(&nothing), &mut scene, &sources)
        .map_err(LookError::from)?;
    Ok(finish(scene, procedural, applied, look, warnings))
}

/// A scene with all that belongs to it, under a light if there is none.
fn finish(
    mut scene: Scene,
    mut procedural: Procedural,
    applied: Applied,
    look: Option<Look>,
    warnings: Vec<String>,
) -> Loaded {
    let Applied {
        camera,
        given_lights,
        has_given_environment,
        has_gone_lights,
    } = applied;
    procedural.give_tangents(&mut scene);
    let mut warnings: Diagnostics = warnings.into_iter().map(Diagnostic::warning).collect();
    if let Some(look) = &look {
        warnings.extend(look.warnings.iter().cloned());
    }
    warnings.extend(procedural.warnings().iter().cloned());
    let states_environment = look.as_ref().is_some_and(|look| look.environment.is_some());
    let is_lamp = |material: u32| procedural.traits(material).is_lamp;
    let has_light = has_given_environment || has_gone_lights;
    if !states_environment && !has_light && has_no_lamp(&scene, is_lamp) {
        scene.environment = Environment::Constant(Vec3::ONE);
        warnings.push(Diagnostic::warning(
            "the scene has neither lamps nor an environment: pictures in files are made under an even white sky; a look can set its own `environment`",
        ));
    }
    Loaded {
        scene,
        procedural,
        camera,
        look,
        given_lights,
        has_given_environment,
        has_gone_lights,
        warnings,
    }
}

impl Loaded {
    /// All files that it was made of: the scene, what it and the look name, the textures in use.
    ///
    /// `files`, `scene` and `look` are as they were given to [`load_from`].
    pub fn files(&self, files: &dyn Files, scene: &Path, look: Option<&Path>) -> Vec<PathBuf> {
        let mut found = files_from(files, scene, self.look.as_ref());
        found.extend(look.map(Path::to_owned));
        let textures = self.procedural.graph().library().textures();
        found.extend(textures.iter().map(|texture| texture.file().path().into()));
        found
    }

    /// The camera for pictures that are so many times as wide as high. Where neither the scene nor the look says what it sees, it is
    /// all of the scene, in narrow pictures, too.
    pub fn camera_for(&self, aspect: f32) -> Camera {
        let is_placed = self.look.as_ref().is_some_and(|look| {
            let camera = &look.camera;
            let place = [&camera.position, &camera.look_at, &camera.up];
            let lens = [&camera.y_fov, &camera.focus_distance];
            place.into_iter().any(Option::is_some) || lens.into_iter().any(Option::is_some)
        });
        match self.scene.cameras.is_empty() && !is_placed {
            true => self.camera.fitted(aspect),
            false => self.camera.clone(),
        }
    }

    /// A camera of the glTF file by name, without the look's overrides.
    ///
    /// # Errors
    /// No camera is called so.
    pub fn camera_named(&self, name: &str) -> Result<Camera, LoadError> {
        let found = self.scene.cameras.iter().find(|c| c.name == name);
        found.cloned().ok_or_else(|| LoadError::UnknownCamera {
            name: name.to_owned(),
            remedy: camera_remedy(&self.scene, name),
        })
    }
}

/// What comes of a look beside its scene.
#[derive(Debug)]
struct Applied {
    camera: Camera,
    given_lights: Vec<PunctualLight>,
    has_given_environment: bool,
    has_gone_lights: bool,
}

impl Applied {
    /// Without a look.
    fn nothing(imported: &Imported, still: Option<&Camera>) -> Self {
        let scene = &imported.scene;
        Self {
            camera: first_camera(scene, still),
            given_lights: scene.lights.clone(),
            has_given_environment: !is_black(&scene.environment),
            has_gone_lights: !imported.names.gone_lights.is_empty(),
        }
    }
}

/// A scene whose own environment can't be read is shown only where the look has another.
fn check_environment(imported: &mut Imported, look: Option<&Look>) -> Result<(), ImportError> {
    let Some(problem) = imported.environment_problem.take() else {
        return Ok(());
    };
    if look.is_none_or(|look| look.environment.is_none()) {
        return Err(problem);
    }
    let warning = format!("{problem}; the look has another environment");
    imported.warnings.push(warning);
    Ok(())
}

/// Everything of the look that is not a material: includes, environment, lights, camera.
fn apply(
    files: &dyn Files,
    look: &Look,
    importer: &mut Importer,
    environments: &mut EnvironmentMaker,
    imported: &mut Imported,
    still: Option<&Camera>,
) -> Result<Applied, LookError> {
    let Imported {
        scene,
        names,
        warnings,
        ..
    } = imported;
    let mut problems = Diagnostics::new();
    let mut gone: BTreeSet<String> = (std::mem::take(&mut names.gone_lights).into_iter())
        .map(|(_, light)| light)
        .collect();
    let has_given_environment = !is_black(&scene.environment);
    for table in &look.includes {
        match include::include(look, table, importer, scene, &mut gone) {
            Ok(more) => warnings.extend(more),
            Err(problem) => problems.push(problem),
        }
        // Further ones would fail for the same reason, each after a while.
        if problems.len() >= MAX_BAD_INCLUDES {
            break;
        }
    }
    if let Some(environment) = &look.environment {
        match environments.set(files, look, environment, scene) {
            Ok(more) => warnings.extend(more),
            Err(problem) => problems.push(problem),
        }
    }
    let given_lights = scene.lights.clone();
    for table in &look.lights {
        problems.extend(light::apply(look, table, scene, &gone).err());
    }
    if let Err(problem) = groups::apply(look, scene) {
        problems.push(problem);
    }
    match camera::resolve(look, scene, still) {
        Ok(camera) if problems.is_empty() => Ok(Applied {
            camera,
            given_lights,
            has_given_environment,
            has_gone_lights: !gone.is_empty(),
        }),
        Ok(_) => Err(problems.into()),
        Err(problem) => {
            problems.push(problem);
            Err(problems.into())
        }
    }
}

/// Makes environments of what a look says of them, and remembers the last one: another moment has the same, as a rule, or at least its
/// picture.
#[derive(Debug, Default)]
struct EnvironmentMaker {
    last: Option<(EnvironmentLook, Environment, Option<PunctualLight>)>,
}

impl EnvironmentMaker {
    /// Gives the scene the look's environment; returns warnings.
    fn set(
        &mut self,
        files: &dyn Files,
        look: &Look,
        wanted: &Spanned<EnvironmentLook>,
        scene: &mut Scene,
    ) -> Result<Vec<String>, Diagnostic> {
        let is_last = matches!(&self.last, Some((of, ..)) if *of == wanted.value);
        let warnings = match is_last || self.turn_to(&wanted.value) {
            true => Vec::new(),
            false => {
                let (environment, sun, warnings) = environment_of(files, look, wanted)?;
                self.last = Some((wanted.value.clone(), environment, sun));
                warnings
            }
        };
        let Some((_, environment, sun)) = &self.last else {
            return Ok(warnings);
        };
        // Before `[light.NAME]` may say otherwise.
        if let (Some(sun), Some(group)) = (sun, &look.environment_group) {
            groups::assign(look, scene, LightSource::Light(&sun.name), group)?;
        }
        scene.environment.clone_from(environment);
        scene.lights.extend(sun.clone());
        Ok(warnings)
    }

    /// Changes how the last picture is shown, if that is the one that is wanted.
    fn turn_to(&mut self, wanted: &EnvironmentLook) -> bool {
        let Some((of, shown, _)) = &mut self.last else {
            return false;
        };
        match (&*of, wanted, shown) {
            (
                EnvironmentLook::Image { image: last, .. },
                EnvironmentLook::Image {
                    image,
                    rotation,
                    intensity,
                },
                Environment::Image {
                    rotation: shown_rotation,
                    intensity: shown_intensity,
                    ..
                },
            ) if last.value == image.value => {
                (*shown_rotation, *shown_intensity) = (*rotation, *intensity);
                *of = wanted.clone();
                true
            }
            _ => false,
        }
    }
}

/// An environment with its sun, and warnings.
fn environment_of(
    files: &dyn Files,
    look: &Look,
    wanted: &Spanned<EnvironmentLook>,
) -> Result<(Environment, Option<PunctualLight>, Vec<String>), Diagnostic> {
    Ok(match &wanted.value {
        EnvironmentLook::Constant(radiance) => (Environment::Constant(*radiance), None, Vec::new()),
        EnvironmentLook::Image {
            image,
            rotation,
            intensity,
        } => {
            let path = look.resolve(&image.value);
            let loaded = import::load_environment_image(files, &path).map_err(|error| {
                Diagnostic::error(error.to_string()).with_label(&look.file, image.span.clone(), "")
            })?;
            let environment = Environment::Image {
                image: Arc::new(loaded.0),
                rotation: *rotation,
                intensity: *intensity,
            };
            (environment, None, loaded.1)
        }
        EnvironmentLook::Sky(sky) => {
            let (environment, sun) = sky.build();
            (environment, sun, Vec::new())
        }
    })
}

/// The camera that a look asks for.
///
/// # Errors
/// There is none of its name, or it has no direction.
pub(crate) fn camera_of(look: &Look, scene: &Scene) -> Result<Camera, Diagnostic> {
    camera::resolve(look, scene, None)
}

fn is_black(environment: &Environment) -> bool {
    matches!(environment, Environment::Constant(c) if c.max_element() <= 0.0)
}

/// Whether all light that there may be comes from the environment, but for signs and displays. It is asked of materials with a program
/// whether they are lamps.
pub(crate) fn has_no_lamp(scene: &Scene, is_driven_lamp: impl Fn(u32) -> bool) -> bool {
    let emits = |(index, material): (usize, &Material)| {
        material.unlit || is_lamp(material) || is_driven_lamp(index as u32)
    };
    scene.lights.is_empty() && !scene.materials.iter().enumerate().any(emits)
}

/// Whether a material is there to give light.
fn is_lamp(material: &Material) -> bool {
    let brightest = material.emission.max_element();
    brightest > BRIGHTEST_DISPLAY || brightest > 0.0 && material.emission_texture.is_none()
}

/// What is seen without a look: the file's first camera, or `still`, or all of the scene.
fn first_camera(scene: &Scene, still: Option<&Camera>) -> Camera {
    let first = scene.cameras.first().or(still).cloned();
    first.unwrap_or_else(|| default_camera(scene))
}

/// What to write instead of the name of a camera that isn't there.
fn camera_remedy(scene: &Scene, name: &str) -> String {
    let names = || scene.cameras.iter().map(|c| c.name.as_str());
    match did_you_mean(name, names()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if scene.cameras.is_empty() => "the scene has no cameras".to_owned(),
        None => format!("it has {}", names().collect::<Vec<_>>().join(", ")),
    }
}

#[cfg(test)]
mod tests;
