//! A scene over time as the render sees it: at each moment the scene, its camera, and what textures are told.

use std::path::PathBuf;
use std::sync::Arc;

use engine::scene::{Camera, Mesh, Scene};
use engine::session::{Inputs, Opening, Sequence, SessionError};
use engine::settings::Beside;
use engine::system::System;
use glam::{Affine3A, DAffine3, DQuat, DVec3, Mat3, Vec3};

use crate::failure::Failure;
use crate::job::RenderJob;
use crate::memory;
use crate::motion::Sight;
use crate::overrides::Overrides;

use super::cameras::find_camera;

/// What is rendered, to be opened at one moment after the other.
pub(super) struct Reel {
    sequence: Sequence,
    camera: Option<String>,
    /// Width of the whole picture over its height.
    aspect: f32,
    said: Said,
}

/// What the command line says of the look, for messages about it.
struct Said {
    look: Option<PathBuf>,
    overrides: Overrides,
}

impl Said {
    fn failure(&self, error: SessionError) -> Failure {
        let look = self.look.as_deref();
        self.overrides.told_failure(look, error.into())
    }
}

/// What is seen at a moment.
pub(super) struct View {
    pub(super) opening: Opening,
    pub(super) sight: Sight,
    /// The scene a frame before and a frame after, for a film that has a layer of motion.
    pub(super) beside: Option<Arc<Beside>>,
}

impl Reel {
    /// Reads the look, and which animations there are where one is asked for.
    ///
    /// # Errors
    /// What can't be read, an environment that there is no memory for; an animation that isn't there.
    pub(super) fn open(job: &RenderJob, inputs: Inputs) -> Result<Self, Failure> {
        let said = Said {
            look: inputs.look.clone(),
            overrides: job.overrides.clone(),
        };
        said.overrides.check_names(said.look.as_deref())?;
        let sequence = Sequence::read(inputs, System::default(), &said.overrides.edits);
        let mut sequence = sequence.map_err(|error| said.failure(error))?;
        memory::check_environment(job)?;
        if let Some(wanted) = &job.motion.animation {
            let animations = sequence.animations()?;
            let names: Vec<&str> = animations.iter().map(|a| a.name.as_str()).collect();
            let number = wanted.parse().ok().filter(|&n: &usize| n < names.len());
            if !names.contains(&wanted.as_str()) && number.is_none() {
                let there = match names.is_empty() {
                    true => "the scene has no animations; leave the flag out".to_owned(),
                    false => format!(
                        "the scene has no animation of this name; it has {}",
                        names.join(", ")
                    ),
                };
                return Err(Failure::Failed(format!("--animation {wanted}: {there}")));
            }
        }
        let [width, height] = (job.crop).map_or([job.width, job.height], |crop| crop.whole);
        Ok(Self {
            sequence,
            camera: job.camera.clone(),
            aspect: width as f32 / height as f32,
            said,
        })
    }

    /// What is seen at a moment.
    ///
    /// # Errors
    /// What can't be read, or makes no sense at that moment.
    pub(super) fn at(&mut self, sight: &Sight) -> Result<View, Failure> {
        let opening = self.sequence.at(&sight.moment);
        let opening = opening.map_err(|error| self.said.failure(error))?;
        self.seen(opening, sight)
    }

    /// How the scene is at two moments.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub(super) fn beside(&mut self, sights: &[Sight; 2]) -> Result<Arc<Beside>, Failure> {
        let mut at = |sight: &Sight| {
            let opening = self.at(sight)?.opening;
            let loaded = opening.loaded();
            let instances = loaded.scene.instances.iter();
            let transforms: Vec<Affine3A> = instances.map(|instance| instance.transform).collect();
            let meshes = loaded.scene.meshes.iter();
            let positions: Vec<Vec<Vec3>> = meshes.map(bent_positions).collect();
            Ok::<_, Failure>((loaded.camera.clone(), transforms, positions))
        };
        let [before, after] = sights;
        let (before, after) = (at(before)?, at(after)?);
        Ok(Arc::new(Beside {
            cameras: [before.0, after.0],
            transforms: [before.1, after.1],
            positions: [before.2, after.2],
        }))
    }

    /// What is seen at the one moment that is wanted.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub(super) fn once(self, sight: &Sight) -> Result<View, Failure> {
        let Self {
            sequence,
            camera,
            aspect,
            said,
        } = self;
        let opening = sequence.once(&sight.moment);
        let opening = opening.map_err(|error| said.failure(error))?;
        seen(camera.as_deref(), aspect, opening, sight)
    }

    fn seen(&self, opening: Opening, sight: &Sight) -> Result<View, Failure> {
        seen(self.camera.as_deref(), self.aspect, opening, sight)
    }
}

/// Where the vertices of a mesh are, if it bends.
fn bent_positions(mesh: &Mesh) -> Vec<Vec3> {
    match mesh.unbent {
        Some(_) => mesh.positions.clone(),
        None => Vec::new(),
    }
}

/// Through the camera of that name, which may have gone around the scene.
fn seen(
    camera: Option<&str>,
    aspect: f32,
    mut opening: Opening,
    sight: &Sight,
) -> Result<View, Failure> {
    let loaded = opening.loaded();
    let camera = match camera {
        Some(wanted) => find_camera(&loaded.scene, wanted)?,
        None => loaded.camera_for(aspect),
    };
    opening = opening.seen_by(camera);
    if sight.turn != 0.0 {
        let loaded = opening.loaded();
        let camera = turned(&loaded.camera, &loaded.scene, sight.turn);
        opening = opening.seen_by(camera);
    }
    Ok(View {
        opening,
        sight: sight.clone(),
        beside: None,
    })
}

/// A camera that has gone around the scene's centre about the vertical, by so many radians.
fn turned(camera: &Camera, scene: &Scene, turn: f64) -> Camera {
    let (low, high) = scene.bounds().unwrap_or_default();
    let centre = low.as_dvec3() * 0.5 + high.as_dvec3() * 0.5;
    let around = DAffine3::from_translation(centre)
        * DAffine3::from_quat(DQuat::from_axis_angle(DVec3::Y, turn))
        * DAffine3::from_translation(-centre);
    let own = DAffine3::from_mat3_translation(
        Mat3::from(camera.transform.matrix3).as_dmat3(),
        Vec3::from(camera.transform.translation).as_dvec3(),
    );
    let moved = around * own;
    let (axes, place) = (moved.matrix3.as_mat3(), moved.translation.as_vec3());
    Camera {
        transform: Affine3A::from_mat3_translation(axes, place),
        ..camera.clone()
    }
}
