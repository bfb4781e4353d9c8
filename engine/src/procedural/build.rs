//! From a look to a [`Procedural`]: textures are parsed, nodes added, arguments set, materials resolved and compiled.

use std::collections::{BTreeSet, HashSet};
use std::path::PathBuf;
use std::sync::Arc;

use texgen::{
    Attribute, BuiltinAttribute, Diagnostic, Diagnostics, Graph, GraphError, Library, NodeId,
    Parameter, TextureType, did_you_mean,
};

use crate::input::Files;
use crate::scene::Scene;
use crate::scene::look::{
    AoSettings, Field, Input, Look, MAX_AO, MODEL_IMAGE, NodeLook, Span, Spanned, misplaced_key,
    unquoted,
};

use super::documents::expanded;
use super::images::Images;
use super::memory::{ProgramMemory, RangeSet};
use super::remarks::remark;
use super::sources::TextureSources;
use super::values::{Argument, ImageArgument, argument};
use super::wiring::CompileError;
use super::{MIN_STACK_SLOTS, Output, Procedural, materials};

impl Procedural {
    /// Brings a look to a scene: sets the constants of its materials, adds the materials and images that the look adds,
    /// and builds the texture graph. Only the textures that nodes of the look use are read.
    ///
    /// # Errors
    /// Every mistake found: in the look's names and values with its line, in a texture with the line of its own file.
    pub fn build(
        look: &Look,
        scene: &mut Scene,
        textures: &TextureSources,
    ) -> Result<Self, Diagnostics> {
        let (look, warnings) = expanded(look, &**textures.files(), Some(&scene.materials))?;
        let look = &*look;
        let mut builder = Builder {
            look,
            problems: Diagnostics::new(),
            warnings,
            files: Arc::clone(textures.files()),
            images: Images::default(),
        };
        let library = builder.library(textures);
        let mut graph = Graph::new(Arc::new(library));
        let (ao, ao_names) = builder.ao(&graph);
        let nodes = builder.add_nodes(&mut graph, ao_names.len());
        for &(table, node) in &nodes {
            builder.set_arguments(&mut graph, table, node, scene);
        }
        let resolved = materials::resolve(look, scene, &graph, &mut builder.problems);
        builder.warn_of_radians(&graph);
        if builder.problems.has_errors() {
            return Err(builder.problems);
        }

        let mut procedural = Self {
            custom_attributes: graph.library().custom_attributes(),
            graph,
            ao,
            ao_names,
            memory: ProgramMemory::new(scene.materials.len()),
            wiring: resolved.wiring,
            traits: Vec::new(),
            order: resolved.order,
            material_names: resolved.names,
            surface_names: resolved.surfaces,
            originals: resolved.originals,
            shown: Vec::new(),
            scene_materials: resolved.in_scene,
            images_with_levels: builder.images.with_levels.into_iter().collect(),
            textures: builder.images.textures,
            files: builder.files,
            along_tangents: HashSet::new(),
            stack_slots: MIN_STACK_SLOTS,
            changed_args: RangeSet::default(),
            shows_args: false,
            changed_ao: false,
            changed_kernel: false,
            warnings: builder.warnings,
        };
        procedural.compile_all(look, &nodes)?;
        procedural.warn_of_missing_attributes(scene);
        procedural.take_changes();
        Ok(procedural)
    }

    fn compile_all(
        &mut self,
        look: &Look,
        nodes: &[(&NodeLook, NodeId)],
    ) -> Result<(), Diagnostics> {
        let mut problems = Diagnostics::new();
        let mut seen = HashSet::new();
        for material in 0..self.wiring.len() as u32 {
            match self.compile(material) {
                Ok(compiled) => self.store(compiled),
                Err(error) => {
                    let message = error.to_string();
                    // Materials may share a faulty node.
                    if seen.insert(message.clone()) {
                        let span = self.place_of(look, nodes, material, &error);
                        problems.push(Diagnostic::error(message).with_label(&look.file, span, ""));
                    }
                }
            }
        }
        self.refresh_ao_masks();
        self.refresh_traits();
        if problems.is_empty() {
            Ok(())
        } else {
            Err(problems)
        }
    }

    /// Where in the look a compile error belongs: the node it names, or the material.
    fn place_of(
        &self,
        look: &Look,
        nodes: &[(&NodeLook, NodeId)],
        material: u32,
        error: &CompileError,
    ) -> Span {
        let in_node = match error {
            CompileError::Graph(graph) => match graph.as_ref() {
                GraphError::MissingValue { node, .. } => {
                    nodes.iter().find(|(table, _)| table.name.value == *node)
                }
                _ => None,
            },
            CompileError::TooManySlots { .. } => None,
        };
        let name = self.material_name(material);
        let in_material = look.materials.iter().find(|m| m.name.value == name);
        match (in_node, in_material) {
            (Some((table, _)), _) => table.name.span.clone(),
            (None, Some(table)) => table.name.span.clone(),
            (None, None) => 0..0,
        }
    }
}

fn folders(directories: &[PathBuf]) -> String {
    let shown: Vec<_> = directories
        .iter()
        .map(|d| d.display().to_string())
        .collect();
    match shown.is_empty() {
        true => "none is there; make one called `user_textures` beside the look or in the current folder, or name one with --textures DIR"
            .to_owned(),
        false => format!(
            "{} (--textures DIR adds one; so does a folder `user_textures` beside the look or in the current folder)",
            shown.join(", ")
        ),
    }
}

struct Builder<'a> {
    look: &'a Look,
    problems: Diagnostics,
    warnings: Diagnostics,
    files: Arc<dyn Files>,
    images: Images,
}

impl<'a> Builder<'a> {
    fn problem(&mut self, span: &Span, message: impl Into<String>, note: Option<String>) {
        let mut problem = Diagnostic::error(message).with_label(&self.look.file, span.clone(), "");
        if let Some(note) = note {
            problem = problem.with_note(note);
        }
        self.problems.push(problem);
    }

    /// Parses the textures that nodes use, in the order of their names, so that a look always gives the same kernel.
    fn library(&mut self, sources: &TextureSources) -> Library {
        let look = self.look;
        let used: BTreeSet<&str> = look
            .nodes
            .iter()
            .map(|n| n.texture.value.as_str())
            .collect();
        let mut types = Vec::new();
        for name in used {
            match sources.read(name) {
                Some(Ok(file)) => match TextureType::parse(file) {
                    Ok(texture) => {
                        self.warnings.extend(texture.warnings().iter().cloned());
                        types.push(texture);
                    }
                    Err(problems) => self.problems.append(problems),
                },
                Some(Err(error)) => {
                    self.problem(&first_use(look, name).span, error.to_string(), None)
                }
                None => {
                    let note = match did_you_mean(name, sources.names()) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => format!(
                            "it would be a file {name}.wgsl in one of the folders with textures: {}",
                            folders(sources.directories())
                        ),
                    };
                    let message = format!("there is no texture called `{name}`");
                    self.problem(&first_use(look, name).span, message, Some(note));
                }
            }
        }
        Library::new(types).unwrap_or_else(|problem| {
            self.problems.push(problem);
            Library::default()
        })
    }

    /// The look's AO tables, or one with built-in settings where a texture reads AO and the look has none.
    fn ao(&self, graph: &Graph) -> ([AoSettings; MAX_AO], Vec<String>) {
        let mut settings = [AoSettings::default(); MAX_AO];
        let mut names = Vec::new();
        for (slot, table) in settings.iter_mut().zip(&self.look.ao) {
            *slot = table.settings;
            names.push(table.name.value.clone());
        }
        if names.is_empty() && graph.library().textures().iter().any(reads_ao) {
            names.push(DEFAULT_AO.to_owned());
        }
        (settings, names)
    }

    fn add_nodes(&mut self, graph: &mut Graph, ao_count: usize) -> Vec<(&'a NodeLook, NodeId)> {
        let look = self.look;
        let mut nodes = Vec::new();
        for table in &look.nodes {
            let Some(texture) = graph.library().get(&table.texture.value) else {
                continue; // has been reported
            };
            self.check_occlusion(table, texture);
            let slot = |name: &Option<Spanned<String>>, otherwise: usize| match name {
                Some(name) => look
                    .ao
                    .iter()
                    .position(|a| a.name.value == name.value)
                    .unwrap_or(0),
                None => otherwise,
            } as u32;
            let second = usize::from(ao_count > 1);
            let occlusion = [slot(&table.occlusion, 0), slot(&table.occlusion1, second)];
            match graph.add_node(&table.name.value, &table.texture.value, occlusion) {
                Ok(node) => nodes.push((table, node)),
                Err(error) => self.problem(&table.name.span, error.to_string(), None),
            }
        }
        nodes
    }

    fn check_occlusion(&mut self, table: &NodeLook, texture: &TextureType) {
        let keys = [
            (&table.occlusion, BuiltinAttribute::AO),
            (&table.occlusion1, BuiltinAttribute::AO1),
        ];
        for (key, attribute) in keys {
            if let (Some(key), false) = (key, texture.attributes().contains(&attribute.into())) {
                let message = format!(
                    "texture `{}` does not read {}: this has no effect",
                    texture.name(),
                    attribute.name()
                );
                let warning =
                    Diagnostic::warning(message).with_label(&self.look.file, key.span.clone(), "");
                self.warnings.push(warning);
            }
        }
    }

    /// Links to an angle gave radians once. A texture whose description names its unit was written since.
    fn warn_of_radians(&mut self, graph: &Graph) {
        let key = Output::ANISOTROPY_ROTATION.key();
        for input in self.look.materials.iter().filter_map(|m| m.input(key)) {
            let Input::Link(link) = &input.value else {
                continue;
            };
            let Some(node) = graph.node(&link.node) else {
                continue;
            };
            let texture = graph.texture(node);
            if texture.docs().to_lowercase().contains("degree") {
                continue;
            }
            let message =
                format!("links to `{key}` give degrees; in earlier versions they gave radians");
            let note = format!(
                "if texture `{0}` gives radians, let it return `degrees(...)`; say \"degrees\" in its description (`///`), \
                 and this message is gone",
                texture.name()
            );
            self.warnings.push(
                Diagnostic::warning(message)
                    .with_label(&self.look.file, input.span.clone(), "")
                    .with_note(note),
            );
        }
    }

    fn set_arguments(
        &mut self,
        graph: &mut Graph,
        table: &NodeLook,
        node: NodeId,
        scene: &mut Scene,
    ) {
        let library = Arc::clone(graph.library());
        let Some(texture) = library.get(&table.texture.value) else {
            return;
        };
        self.check_keys(table, texture);
        for field in &table.params {
            let Some(parameter) = texture
                .parameters()
                .iter()
                .find(|p| p.name == field.key.value)
            else {
                self.unknown_parameter(&field.key, texture);
                continue;
            };
            match argument(&field.value, parameter.ty) {
                Ok(argument) => {
                    self.warn_of(field, parameter, &argument);
                    self.set_argument(graph, node, field, parameter, argument, scene);
                }
                Err(bad) => self.problem(
                    &bad.span,
                    format!("`{}`: {}", parameter.name, bad.message),
                    None,
                ),
            }
        }
    }

    /// Points out what is wrong or odd at other moments than this one.
    fn check_keys(&mut self, table: &NodeLook, texture: &TextureType) {
        for field in &table.keyed {
            let mut parameters = texture.parameters().iter();
            let Some(parameter) = parameters.find(|p| p.name == field.key.value) else {
                continue; // is reported once
            };
            match argument(&field.value, parameter.ty) {
                Ok(argument) => self.warn_of(field, parameter, &argument),
                Err(bad) => self.problem(
                    &bad.span,
                    format!("`{}`: {}", parameter.name, bad.message),
                    None,
                ),
            }
        }
    }

    fn warn_of(&mut self, field: &Field, parameter: &Parameter, argument: &Argument) {
        if let Some((message, note)) = remark(&field.value.value, parameter, argument) {
            let span = field.value.span.clone();
            let warning = Diagnostic::warning(message).with_label(&self.look.file, span, "");
            self.warnings.push(match note {
                Some(note) => warning.with_note(note),
                None => warning,
            });
        }
    }

    fn unknown_parameter(&mut self, key: &Spanned<String>, texture: &TextureType) {
        let names = || texture.parameters().iter().map(|p| p.name.as_str());
        let reserved = ["texture", "occlusion", "occlusion1"];
        let near = did_you_mean(&key.value, names().chain(reserved));
        let note = match (misplaced_key(&key.value), near) {
            (Some(remedy), _) => remedy,
            (None, Some(near)) => format!("did you mean `{near}`?"),
            (None, None) if texture.parameters().is_empty() => "it has no parameters".to_owned(),
            (None, None) => format!("it has: {}", names().collect::<Vec<_>>().join(", ")),
        };
        let message = format!(
            "texture `{}` has no parameter `{}`",
            texture.name(),
            key.value
        );
        self.problem(&key.span, message, Some(note));
    }

    fn set_argument(
        &mut self,
        graph: &mut Graph,
        node: NodeId,
        field: &Field,
        parameter: &Parameter,
        argument: Argument,
        scene: &mut Scene,
    ) {
        let result = match argument {
            Argument::Constant(value) => graph.set_value(node, &parameter.name, value),
            Argument::Image(image) => match self.image(&image, parameter, scene) {
                Some(handle) => {
                    if graph.texture(node).reads_levels() {
                        self.images.read_levels(handle);
                    }
                    graph.set_value(node, &parameter.name, texgen::Value::Image(handle))
                }
                None => return,
            },
            Argument::Link(link) => {
                let Some(source) = graph.node(&link.node) else {
                    self.unknown_node(&field.value.span, &link.node);
                    return;
                };
                graph.set_link(node, &parameter.name, source, link.swizzle)
            }
        };
        if let Err(error) = result {
            self.problem(&field.value.span, error.to_string(), None);
        }
    }

    fn unknown_node(&mut self, span: &Span, name: &str) {
        let names = || self.look.nodes.iter().map(|n| n.name.value.as_str());
        if names().any(|n| n == name) {
            return; // its texture has been reported
        }
        let note = match (unquoted(name), did_you_mean(name, names())) {
            (Some(remedy), _) => remedy,
            (None, Some(near)) => format!("did you mean `{near}`?"),
            (None, None) => {
                "declare it with [node.NAME], or write a colour as \"#rrggbb\"".to_owned()
            }
        };
        self.problem(
            span,
            format!("there is no node called `{name}`"),
            Some(note),
        );
    }

    fn image(
        &mut self,
        image: &ImageArgument,
        parameter: &Parameter,
        scene: &mut Scene,
    ) -> Option<u32> {
        if let Some(name) = image.file.value.strip_prefix(MODEL_IMAGE) {
            let srgb = image.srgb.unwrap_or(!parameter.is_data);
            let found = self.images.of_model(scene, name, srgb, image.sampler);
            return found
                .map_err(|error| {
                    let message = format!("the image `{name}`: {error}");
                    let note = "`patina info` lists the images of a model";
                    self.problem(&image.file.span, message, Some(note.to_owned()));
                })
                .ok();
        }
        let path = self.look.resolve(&image.file.value);
        let srgb = image.srgb.unwrap_or(!parameter.is_data);
        let files = &*self.files;
        match (self.images).handle(files, scene, &path, srgb, image.sampler) {
            Ok(handle) => {
                for lost in self.images.losses.drain(..) {
                    let span = image.file.span.clone();
                    let warning = Diagnostic::warning(lost).with_label(&self.look.file, span, "");
                    self.warnings.push(warning);
                }
                Some(handle)
            }
            Err(error) => {
                let message = format!("the image {}: {error}", path.display());
                let note = "paths are relative to the look file";
                self.problem(&image.file.span, message, Some(note.to_owned()));
                None
            }
        }
    }
}

fn first_use<'l>(look: &'l Look, texture: &str) -> &'l Spanned<String> {
    let found = look.nodes.iter().find(|n| n.texture.value == texture);
    &found
        .expect("the name was taken from one of the nodes")
        .texture
}

/// Name of the AO table that a look without any has once a texture reads it.
pub(super) const DEFAULT_AO: &str = "default";

pub(super) fn reads_ao(texture: &TextureType) -> bool {
    [BuiltinAttribute::AO, BuiltinAttribute::AO1]
        .into_iter()
        .any(|ao| texture.attributes().contains(&Attribute::from(ao)))
}
