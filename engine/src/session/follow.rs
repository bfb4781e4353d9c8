//! How graph, scene and GPU follow a changed look by writes to buffers.

use texgen::{Diagnostic, Diagnostics, SourceFile};

use crate::load::{self, StandIn};
use crate::procedural::{UpdateError, expanded};
use crate::renderer::Touched;
use crate::scene::look::{
    EnvironmentLook, Field, Look, LookDocument, MaterialLook, Section, Spanned, Table, Value, find,
    placed_fields, table,
};
use crate::scene::view::ViewChoice;
use crate::scene::{Camera, Environment, Material, Motion, PunctualLight};

use super::difference::{TableChange, difference};
use super::edit::{Edit, summary};
use super::moment::has_keys;
use super::{Problems, Session, SessionError};

/// Tables of documents that give a look materials.
const DOCUMENTS: &str = "materialx";

/// What following may change of the scene.
struct Before {
    materials: Vec<Material>,
    environment: EnvironmentFactors,
    camera: Camera,
    look_view: ViewChoice,
    lights: Vec<PunctualLight>,
}

/// The part of an environment that is edited.
#[derive(Clone, Copy)]
enum EnvironmentFactors {
    Constant(glam::Vec3),
    Image { rotation: f32, intensity: f32 },
}

impl Session {
    /// Edits the look. What can be written to buffers is written before this returns, and the picture has begun anew;
    /// what can't is built in the background.
    ///
    /// # Errors
    /// The edit makes no sense, or the device; then the look is as before.
    pub fn edit(&mut self, edit: &Edit) -> Result<(), SessionError> {
        let section = edit.section();
        let before = self.document.table(section);
        // Only one table is kept aside: copying a whole look takes as long as many edits.
        let kept = self.document.keep(section);
        if let Err(why) = edit.write(&mut self.document) {
            self.document.put_back(section, kept);
            return Err(SessionError::Refused(why));
        }
        let after = self.document.table(section);
        let change = TableChange {
            section: section.clone(),
            before,
            after,
            span: 0..0,
        };
        if self.shown.is_some() {
            self.catch_up();
            return Ok(());
        }
        let file = SourceFile::new("look", "", "");
        let mut touched = Touched::default();
        let followed = self.follow(&file, &change, &mut touched);
        let outcome = followed.and_then(|()| match is_of_samples(section) {
            true => self.commit(touched),
            false => Ok(()),
        });
        let Err(error) = outcome else {
            // Textures that didn't fit the look may do so now; a number of a material has no part in that.
            let concerns_textures = matches!(section, Section::Node(_))
                || texts(change.before.as_deref()) != texts(change.after.as_deref());
            self.again.sources |=
                concerns_textures && (self.is_unfit || !self.problems.gone.is_empty());
            return Ok(());
        };
        // What it was is right, so nothing of it is refused; nor has anything been written.
        let _ = self.follow(&file, &change.reversed(), &mut Touched::default());
        match error {
            UpdateError::Refused(problems) => {
                self.document.put_back(section, kept);
                Err(SessionError::Refused(summary(&problems)))
            }
            UpdateError::Rebuild | UpdateError::NewTexture => {
                let wanted = self.document.clone();
                self.document.put_back(section, kept);
                self.shown = Some(self.document.fields());
                self.document = wanted;
                self.catch_up();
                Ok(())
            }
        }
    }

    /// Does several edits as one.
    ///
    /// # Errors
    /// As [`Self::edit`], at the first one that is refused; those before it stay.
    pub fn edit_all<'e>(
        &mut self,
        edits: impl IntoIterator<Item = &'e Edit>,
    ) -> Result<(), SessionError> {
        edits.into_iter().try_for_each(|edit| self.edit(edit))
    }

    /// Replaces the whole text of the look, as an undo does. What differs is followed table by table where writes to
    /// buffers suffice, and built in the background where they don't; what is wrong with it is told by
    /// [`Self::problems`], and the picture stays until that is mended. No file is written.
    ///
    /// # Errors
    /// The text isn't in the form of a look; then the look is as before.
    pub fn replace_look(&mut self, text: &str) -> Result<(), SessionError> {
        let refused = |problems: Diagnostics| SessionError::Refused(summary(&problems));
        Look::parse(&self.look_path(), text).map_err(refused)?;
        let document = super::parse_look(&self.inputs, text).map_err(refused)?;
        self.want(document);
        Ok(())
    }

    /// Shows another look, as soon as it can be shown.
    pub(super) fn want(&mut self, document: LookDocument) {
        let former = self.document.fields();
        self.shown.get_or_insert(former);
        self.document = document;
        self.catch_up();
    }

    /// Writes what has changed to the device; all of it can be written, or nothing is.
    fn commit(&mut self, touched: Touched) -> Result<(), UpdateError> {
        // A scene without any light is shown by another one, unless the look says what is there.
        let is_told = self.document.table(&Section::Environment).is_some();
        if touched.materials && !is_told && self.has_no_lamp() != self.was_without_lamp {
            return Err(UpdateError::Rebuild);
        }
        if (self.renderer.procedural()).lacks_tangents(&self.scene.materials) {
            return Err(UpdateError::Rebuild);
        }
        let camera = self.view.as_ref().unwrap_or(&self.camera);
        let restarts = self.renderer.restarts();
        match self.renderer.update(&self.scene, camera, touched) {
            Ok(true) => {
                // What cannot be seen leaves the picture as it is.
                self.generation += u64::from(self.renderer.restarts() != restarts);
                Ok(())
            }
            Ok(false) => Err(UpdateError::Rebuild),
            Err(error) => Err(UpdateError::Refused(
                Diagnostic::error(error.to_string()).into(),
            )),
        }
    }

    /// Neither scene nor look has any light, so that all is seen by one that nobody asked for.
    pub fn has_stand_in_light(&self) -> bool {
        let is_told = self.document.table(&Section::Environment).is_some();
        !is_told && self.was_without_lamp
    }

    /// Is seen by this from now on where there is no light: see [`Opening::lit_by`](super::Opening::lit_by).
    pub fn set_stand_in(&mut self, stand_in: StandIn) {
        if stand_in == self.stand_in {
            return;
        }
        self.stand_in = stand_in;
        if self.has_stand_in_light() {
            self.rebuild();
        }
    }

    pub(super) fn has_no_lamp(&self) -> bool {
        let procedural = self.renderer.procedural();
        let is_lamp = |material| procedural.traits(material).is_lamp;
        let has_light = self.has_given_environment || self.has_gone_lights;
        !has_light && load::has_no_lamp(&self.scene, is_lamp)
    }

    /// Brings what is shown to what is wanted: by writes if they suffice, else in the background.
    pub(super) fn catch_up(&mut self) {
        let Some(shown) = self.shown.take() else {
            return;
        };
        let text = self.document.text();
        let wanted = placed_fields(&text);
        let Some(changes) = difference(&shown, &wanted) else {
            self.shown = Some(shown);
            return self.rebuild_for_look();
        };
        if changes.is_empty() {
            return self.caught_up();
        }
        // Checked as a whole, so that mistakes between tables are found with their places.
        let file = self.look_file(&text);
        if let Err(problems) = Look::parse(&self.look_path(), &text) {
            self.shown = Some(shown);
            self.problems.look = problems;
            return;
        }
        match self.follow_all(&file, &changes) {
            Ok(()) => self.caught_up(),
            Err(error) => {
                self.shown = Some(shown);
                match error {
                    UpdateError::NewTexture => self.load_textures(&changes),
                    // It may fit the textures as they are now.
                    UpdateError::Refused(_) if self.is_unfit => self.rebuild_for_look(),
                    UpdateError::Refused(problems) if changes.len() == 1 => {
                        self.problems.look = problems;
                    }
                    // A link may fit only after another table has changed: from the start there is no such order.
                    _ => self.rebuild_for_look(),
                }
            }
        }
    }

    fn caught_up(&mut self) {
        self.problems.look = Diagnostics::new();
        // A texture that was in the way may not be wanted any more.
        let Problems { sources, gone, .. } = &self.problems;
        self.again.sources |= self.is_unfit || !sources.is_empty() || !gone.is_empty();
        // Nor were files of the scene shown that came while the look was wrong.
        self.again.assets |= std::mem::take(&mut self.is_behind);
    }

    /// Follows several changes, all or none.
    fn follow_all(
        &mut self,
        file: &SourceFile,
        changes: &[TableChange],
    ) -> Result<(), UpdateError> {
        let before = self.before();
        let procedural = self.renderer.procedural().clone();
        let mut touched = Touched::default();
        // Nodes first, so that links find them in any order.
        let added = changes.iter().filter(|change| change.before.is_none());
        let outcome = added
            .map(|change| TableChange {
                after: change.after.as_ref().map(|after| {
                    let texture = after.iter().find(|field| field.key.value == "texture");
                    texture.cloned().into_iter().collect()
                }),
                ..change.clone()
            })
            .filter(|change| matches!(change.section, Section::Node(_)))
            .try_for_each(|change| self.follow(file, &change, &mut touched))
            .and_then(|()| {
                let mut changes = changes.iter();
                changes.try_for_each(|change| self.follow(file, change, &mut touched))
            });
        let is_of_samples = changes.iter().any(|change| is_of_samples(&change.section));
        let outcome = outcome.and_then(|()| match is_of_samples {
            true => self.commit(touched),
            false => Ok(()),
        });
        if outcome.is_err() {
            *self.renderer.procedural_mut() = procedural;
            self.restore(before);
        }
        outcome
    }

    /// Changes graph, scene and camera; nothing is written to the device.
    fn follow(
        &mut self,
        file: &SourceFile,
        change: &TableChange,
        touched: &mut Touched,
    ) -> Result<(), UpdateError> {
        let TableChange {
            section,
            before,
            after,
            span,
        } = change;
        let fields = after.as_deref().unwrap_or_default();
        // Groups of lights are numbered over the whole look.
        let group = |fields: &[Field]| find(fields, "group").map(|value| value.value.clone());
        let is_of_light = matches!(section, Section::Environment | Section::Material(_));
        if is_of_light && group(before.as_deref().unwrap_or_default()) != group(fields) {
            return Err(UpdateError::Rebuild);
        }
        if self.moment.seconds != 0.0 && has_keys(fields) {
            return Err(UpdateError::Rebuild);
        }
        if let Section::Light(name) = section {
            touched.lights = true;
            return self.follow_light(file, name, change);
        }
        let is_kept = before.is_some() && after.is_some();
        if matches!(section, Section::Node(_)) && !is_kept && self.document.has(DOCUMENTS) {
            // A document may have a node of that name, whose place it takes.
            return Err(UpdateError::Rebuild);
        }
        let given = match section {
            Section::Material(name) => self.document_material(name)?,
            _ => None,
        };
        let read = |file| table(file, section, fields, span).map_err(UpdateError::Refused);
        if let (Section::Frame(_), None) = (section, after) {
            return Ok(());
        }
        let procedural = self.renderer.procedural_mut();
        if let (Section::Node(name), None) = (section, after) {
            return procedural.release_node(name);
        }
        if let (Section::Material(name), None) = (section, after) {
            let bare = || MaterialLook::new(Spanned::new(name.clone(), span.clone()));
            let table = given.unwrap_or_else(bare);
            touched.materials = true;
            return procedural.update_material(&mut self.scene, file, &table);
        }
        if let (Section::Ao(_) | Section::Environment, None) = (section, after) {
            return Err(UpdateError::Rebuild);
        }
        match (section, read(file)?) {
            (_, Table::Node(node)) => {
                procedural.update_node(file, before.as_deref().unwrap_or_default(), &node)
            }
            (_, Table::Material(mut material)) => {
                if let Some(given) = given {
                    material.stand_over(given);
                }
                touched.materials = true;
                procedural.update_material(&mut self.scene, file, &material)
            }
            (Section::Ao(name), Table::Ao(settings)) if before.is_some() => {
                procedural.update_ao(name, settings)
            }
            (_, Table::Environment(environment)) if before.is_some() => {
                let image = |fields| find(fields, "image").map(|value| value.value.clone());
                if image(before.as_deref().unwrap_or_default()) != image(fields) {
                    return Err(UpdateError::Rebuild);
                }
                touched.environment = true;
                self.follow_environment(&environment)
            }
            (_, Table::Frame(_)) => Ok(()),
            (_, Table::View(view)) => {
                self.look_view = view;
                Ok(())
            }
            (_, Table::Camera(camera)) => {
                if self.inputs.camera.is_some() {
                    return Ok(());
                }
                // A camera that the scene hasn't starts from a view of the scene at rest, which isn't here.
                let is_at_rest = self.moment.motion == Motion::Rest;
                if self.scene.cameras.is_empty() && !is_at_rest {
                    return Err(UpdateError::Rebuild);
                }
                let mut look = Look::empty(&self.look_path(), file.clone());
                look.camera = camera;
                touched.camera = true;
                self.camera = load::camera_of(&look, &self.scene)
                    .map_err(|problem| UpdateError::Refused(problem.into()))?;
                Ok(())
            }
            _ => Err(UpdateError::Rebuild),
        }
    }

    /// What the look's documents give a material, whatever the look itself says of it.
    fn document_material(&self, name: &str) -> Result<Option<MaterialLook>, UpdateError> {
        if !self.document.has(DOCUMENTS) {
            return Ok(None);
        }
        // What is wrong with it is told where all is built.
        let path = self.look_path();
        let look = Look::parse(&path, &self.document.text()).map_err(|_| UpdateError::Rebuild)?;
        let documents = Look {
            materialx: look.materialx,
            ..Look::empty(&path, look.file)
        };
        let given = expanded(&documents, &*self.system.files, None);
        let (given, _) = given.map_err(|_| UpdateError::Rebuild)?;
        let mut materials = given.into_owned().materials.into_iter();
        Ok(materials.find(|material| material.name.value == name))
    }

    fn follow_environment(&mut self, wanted: &EnvironmentLook) -> Result<(), UpdateError> {
        let factors = match *wanted {
            EnvironmentLook::Constant(radiance) => EnvironmentFactors::Constant(radiance),
            EnvironmentLook::Image {
                rotation,
                intensity,
                ..
            } => EnvironmentFactors::Image {
                rotation,
                intensity,
            },
            // Another sun is another picture of the sky.
            EnvironmentLook::Sky(_) => return Err(UpdateError::Rebuild),
        };
        match set_factors(&mut self.scene.environment, factors) {
            true => Ok(()),
            false => Err(UpdateError::Rebuild),
        }
    }

    fn before(&self) -> Before {
        Before {
            materials: self.scene.materials.clone(),
            environment: match self.scene.environment {
                Environment::Constant(radiance) => EnvironmentFactors::Constant(radiance),
                Environment::Image {
                    rotation,
                    intensity,
                    ..
                } => EnvironmentFactors::Image {
                    rotation,
                    intensity,
                },
            },
            camera: self.camera.clone(),
            look_view: self.look_view,
            lights: self.scene.lights.clone(),
        }
    }

    fn restore(&mut self, before: Before) {
        self.scene.materials = before.materials;
        self.camera = before.camera;
        self.look_view = before.look_view;
        self.scene.lights = before.lights;
        set_factors(&mut self.scene.environment, before.environment);
    }
}

/// What a table links to, among other names.
fn texts(fields: Option<&[Field]>) -> Vec<(&str, &str)> {
    let fields = fields.unwrap_or_default().iter();
    fields
        .filter_map(|field| match &field.value.value {
            Value::Text(text) => Some((field.key.value.as_str(), text.as_str())),
            _ => None,
        })
        .collect()
}

/// Whether the samples of the picture depend on a table, and not only how they are shown.
fn is_of_samples(section: &Section) -> bool {
    !matches!(section, Section::View | Section::Frame(_))
}

/// False where the environment is of the other kind.
fn set_factors(environment: &mut Environment, factors: EnvironmentFactors) -> bool {
    match (environment, factors) {
        (Environment::Constant(radiance), EnvironmentFactors::Constant(wanted)) => {
            *radiance = wanted;
            true
        }
        (
            Environment::Image {
                rotation,
                intensity,
                ..
            },
            EnvironmentFactors::Image {
                rotation: wanted_rotation,
                intensity: wanted_intensity,
            },
        ) => {
            (*rotation, *intensity) = (wanted_rotation, wanted_intensity);
            true
        }
        _ => false,
    }
}
