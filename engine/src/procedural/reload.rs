//! Textures whose files changed: the same graph, wiring and values over their new sources, as plain data. Building the
//! kernel and swapping it is the renderer's.

use std::sync::Arc;

use texgen::{
    Diagnostic, Diagnostics, GraphError, Library, ParameterType, SourceFile, TextureType,
};

use super::build::{DEFAULT_AO, reads_ao};
use super::reads::reads_tangents;
use super::sources::{SourcesError, TextureSources};
use super::wiring::{CompileError, check_driver};
use super::{EditError, Kind, Output, Procedural};

impl Procedural {
    /// The textures of the kernel whose sources are no longer what they were, read anew. A texture whose file is gone
    /// stays what it is.
    ///
    /// # Errors
    /// A file that is there can't be read.
    pub fn changed_sources(
        &self,
        sources: &TextureSources,
    ) -> Result<Vec<SourceFile>, SourcesError> {
        let textures = self.graph().library().textures().iter();
        textures
            .filter_map(|texture| match sources.read(texture.name())? {
                Ok(file) => {
                    let former = texture.file();
                    let is_same =
                        file.text() == former.text() && file.libraries() == former.libraries();
                    (!is_same).then_some(Ok(file))
                }
                Err(error) => Some(Err(error)),
            })
            .collect()
    }

    /// The textures of nodes that aren't among the sources any more. Nodes that the look is said not to name count as far as something
    /// reads them.
    pub(crate) fn gone_sources(
        &self,
        sources: &TextureSources,
        is_named: impl Fn(&str) -> bool,
    ) -> impl Iterator<Item = &str> {
        let graph = self.graph();
        let is_used = move |node| is_named(graph.name(node)) || self.is_read(node);
        let textures = graph.library().textures().iter().map(TextureType::name);
        textures.filter(move |&name| {
            let mut nodes = graph.ids().filter(|&id| graph.texture(id).name() == name);
            sources.is_missing(name) && nodes.any(&is_used)
        })
    }

    /// Its library with these files in the place of the textures of their names, or beside them.
    ///
    /// # Errors
    /// Everything that is wrong with the files, with its lines.
    pub fn library_with(&self, files: Vec<SourceFile>) -> Result<Library, Diagnostics> {
        let mut problems = Diagnostics::new();
        let mut textures: Vec<TextureType> = self.graph().library().textures().to_vec();
        for file in files {
            match TextureType::parse(file) {
                Ok(texture) => {
                    // In the order of their names, as from the start.
                    match textures.binary_search_by(|t| t.name().cmp(texture.name())) {
                        Ok(at) => textures[at] = texture,
                        Err(at) => textures.insert(at, texture),
                    }
                }
                Err(found) => problems.append(found),
            }
        }
        match problems.has_errors() {
            true => Err(problems),
            false => Library::new(textures).map_err(Diagnostics::from),
        }
    }

    /// Whether another library's textures read what was loaded: the images of nodes as colours or as data, with mip levels or without;
    /// tangents.
    pub(crate) fn reads_as_loaded(&self, library: &Library) -> bool {
        let graph = self.graph();
        let mut used = graph.ids().map(|node| graph.texture(node));
        used.all(|texture| match library.get(texture.name()) {
            Some(now) => {
                let read = |texture: &TextureType| {
                    let parameters = texture.parameters().iter();
                    let images =
                        parameters.filter(|parameter| parameter.ty == ParameterType::Image);
                    let images = images.map(|image| (image.name.clone(), image.is_data));
                    (texture.reads_levels(), images.collect::<Vec<_>>())
                };
                let (old, new) = (read(texture), read(now));
                // Without images there is nothing to be read.
                let has_images = !(old.1.is_empty() && new.1.is_empty());
                !(reads_tangents(now) && !reads_tangents(texture) || has_images && old != new)
            }
            None => true,
        })
    }

    /// The same nodes, values, links and materials over another library. Parameters that are new have their defaults,
    /// those that are gone are forgotten, and a value that fits no more gives way to its default with a warning. The
    /// warnings are those of this change.
    ///
    /// # Errors
    /// A texture in use is gone; a link, to a parameter or a material, whose type doesn't fit any more; an image that
    /// is missing. They are shown in the texture's file.
    pub fn with_library(&self, library: Arc<Library>) -> Result<Self, Diagnostics> {
        let (graph, dropped) = self
            .graph
            .with_library(Arc::clone(&library))
            .map_err(|error| self.of_graph(&library, &error))?;
        let former = Arc::clone(self.graph.library());
        self.check_loaded(&library)?;
        let mut new = Self {
            graph,
            ..self.clone()
        };
        new.check_drivers()?;
        new.ensure_ao();
        for material in 0..new.wiring.len() as u32 {
            let compiled = new.compile(material).map_err(|error| match &error {
                CompileError::Graph(error) => self.of_graph(&library, error),
                CompileError::TooManySlots { .. } => Diagnostic::error(error.to_string()).into(),
            })?;
            new.store(compiled);
        }
        new.refresh_ao_masks();
        new.refresh_traits();
        new.take_changes();
        new.warnings = dropped
            .iter()
            .map(|value| Diagnostic::warning(value.to_string()))
            .collect();
        for texture in library.textures() {
            if former.get(texture.name()).map(TextureType::file) != Some(texture.file()) {
                new.warnings.extend(texture.warnings().iter().cloned());
            }
        }
        Ok(new)
    }

    /// Whether what the textures of a library read of the meshes is what was loaded: the kernel asks by number.
    fn check_loaded(&self, library: &Library) -> Result<(), Diagnostics> {
        let wanted = library.custom_attributes();
        if wanted == self.custom_attributes {
            return Ok(());
        }
        let differs = |a: &[String], b: &[String]| a.iter().find(|name| !b.contains(name)).cloned();
        let name = differs(&wanted, &self.custom_attributes)
            .or_else(|| differs(&self.custom_attributes, &wanted))
            .unwrap_or_default();
        let message = format!(
            "textures begin or cease to read the mesh attribute `{name}`, which belongs to the geometry"
        );
        let reader = library.textures().iter().find(|texture| {
            let custom = texgen::Attribute::Custom(name.clone());
            texture.attributes().contains(&custom)
        });
        let diagnostic = Diagnostic::error(message).with_note("load the scene again");
        Err(match reader {
            Some(texture) => at_entry(diagnostic, texture.file()).into(),
            None => diagnostic.into(),
        })
    }

    /// Adds a node of a texture of the library, with default values; nothing reads it yet.
    ///
    /// # Errors
    /// Unknown texture; a node of that name exists.
    pub fn add_node(&mut self, name: &str, texture: &str) -> Result<(), EditError> {
        let second = u32::from(self.ao_count() > 1);
        let before = self.args().len() as u32;
        self.graph.add_node(name, texture, [0, second])?;
        self.changed_args.add(before..self.args().len() as u32);
        Ok(())
    }

    /// A look without AO tables has one with built-in settings as soon as a texture reads it.
    fn ensure_ao(&mut self) {
        if self.ao_names.is_empty() && self.graph.library().textures().iter().any(reads_ao) {
            self.ao_names.push(DEFAULT_AO.to_owned());
            self.changed_ao = true;
        }
    }

    /// Whether what drives the materials still can.
    fn check_drivers(&self) -> Result<(), Diagnostics> {
        let mut problems = Diagnostics::new();
        for (material, wiring) in (0..).zip(&self.wiring) {
            let outputs = Output::ALL
                .into_iter()
                .filter_map(|output| Some((output.key(), output.kind(), wiring.output(output)?)));
            let mask = wiring.mask().map(|mask| ("mask", Kind::Scalar, *mask));
            for (key, kind, source) in outputs.chain(mask) {
                if let Err(message) = check_driver(&self.graph, source, kind) {
                    let name = self.material_name(material);
                    let message = format!("`{key}` of material `{name}`: {message}");
                    let file = self.graph.texture(source.node).file();
                    problems.push(at_entry(Diagnostic::error(message), file));
                }
            }
        }
        match problems.is_empty() {
            true => Ok(()),
            false => Err(problems),
        }
    }

    /// A graph's error in the file of the texture whose change brought it about.
    fn of_graph(&self, library: &Library, error: &GraphError) -> Diagnostics {
        let diagnostic = Diagnostic::error(error.to_string());
        let concerned: &[&String] = match error {
            GraphError::LinkType {
                node, source_node, ..
            } => &[node, source_node],
            GraphError::MissingValue { node, .. } => &[node],
            GraphError::LinkSwizzle { source_node, .. }
            | GraphError::UnknownOutput { source_node, .. } => &[source_node],
            _ => &[],
        };
        let texture_of = |node: &str| {
            let former = self.graph.texture(self.graph.node(node)?);
            let new = library.get(former.name())?;
            Some((new.file(), new.file() != former.file()))
        };
        let files: Vec<_> = concerned
            .iter()
            .filter_map(|node| texture_of(node))
            .collect();
        let changed = files.iter().find(|(_, has_changed)| *has_changed);
        match changed.or(files.first()) {
            Some((file, _)) => at_entry(diagnostic, file).into(),
            None => diagnostic.into(),
        }
    }
}

/// Points at the texture's signature, where parameters and result are declared.
fn at_entry(diagnostic: Diagnostic, file: &SourceFile) -> Diagnostic {
    let start = file.text().find("fn userProc").unwrap_or(0);
    let length = file.text()[start..].lines().next().map_or(0, str::len);
    diagnostic.with_label(file, start..start + length, "")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use texgen::Value;

    use super::*;
    use crate::scene::look::Look;
    use crate::scene::{Material, Scene};

    const LOOK: &str = "[node.a]\ntexture = \"t\"\nx = 2.0\ny = [1, 2, 3]\n[node.b]\ntexture = \"t\"\nx = \"a.y\"\n[material.A]\nbase_color = \"b\"\nroughness = \"a.x\"\n";
    const OLD: &str = "fn userProc(x: f32, y: vec3f) -> vec3f { return x * y; }";

    fn built(look: &str, text: &str) -> Procedural {
        let mut sources = TextureSources::default();
        sources.insert("t", text);
        let look = Look::parse(Path::new("a.look.toml"), look).unwrap_or_else(|e| panic!("{e}"));
        let mut scene = Scene {
            materials: vec![Material {
                name: "A".to_owned(),
                ..Material::default()
            }],
            ..Scene::default()
        };
        Procedural::build(&look, &mut scene, &sources).unwrap_or_else(|e| panic!("{e}"))
    }

    fn reloaded(old: &Procedural, text: &str) -> Result<Procedural, Diagnostics> {
        let library = old.library_with(vec![SourceFile::new("t", "t.wgsl", text)])?;
        old.with_library(Arc::new(library))
    }

    #[test]
    fn a_new_version_is_what_it_would_have_been_from_the_start() {
        let old = built(LOOK, OLD);
        for text in [
            "fn userProc(x: f32, y: vec3f) -> vec3f { return x + y; }",
            "/// @param z = 5\nfn userProc(z: vec4f, y: vec3f, x: f32, r: ramp1D) -> vec4f { return x * z + rampEval(r, y.x); }",
        ] {
            let (new, fresh) = (
                reloaded(&old, text).unwrap_or_else(|e| panic!("{e}")),
                built(LOOK, text),
            );
            assert_eq!(new.kernel().wgsl, fresh.kernel().wgsl);
            assert_eq!(new.programs(), fresh.programs());
            assert_eq!(new.args(), fresh.args());
            assert!(new.warnings().is_empty(), "{}", new.warnings());
        }
    }

    #[test]
    fn parameters_may_come_go_and_change() {
        let old = built(LOOK, OLD);
        let text = "/// @param y = 4\n/// @param z = 9\nfn userProc(y: i32, z: f32) -> vec3f { return vec3f(f32(y) * z); }";
        let new = reloaded(&old, text).unwrap_or_else(|e| panic!("{e}"));
        let value = |p: &Procedural, parameter| {
            let node = p.graph().node("a").expect("kept");
            p.graph().value(node, parameter).cloned()
        };
        assert_eq!(value(&new, "x"), None);
        assert_eq!(value(&new, "y"), Some(Value::I32(4)));
        assert_eq!(value(&new, "z"), Some(Value::F32(9.0)));
        let report = new.warnings().to_string();
        assert!(
            report.contains("parameter `y` of `a` is of type i32 now"),
            "{report}"
        );
        assert_eq!(value(&old, "y"), Some(Value::Vec3([1.0, 2.0, 3.0])));
    }

    #[test]
    fn what_does_not_fit_is_refused_in_the_textures_file() {
        let old = built(LOOK, OLD);
        for (text, parts) in [
            (
                "fn userProc(x: f32) -> vec3f {\n    return q;\n}",
                ["t.wgsl:2:12", "`q`"],
            ),
            (
                "// two\nfn userProc(x: mat3x3f) -> vec3f { return x[0]; }",
                ["t.wgsl:2:1", "parameter `x` of `b` is of type mat3x3f"],
            ),
            (
                "fn userProc(x: f32) -> f32 { return x; }",
                ["t.wgsl:1:1", "it has no `.y`"],
            ),
            (
                "fn userProc(x: f32) -> vec2f { return vec2f(x); }",
                ["t.wgsl:1:1", "`base_color` of material `A`"],
            ),
            (
                "fn userProc(x: f32, i: sam2D) -> vec3f { return tex2D(i, vec2f(x)).xyz; }",
                ["t.wgsl:1:1", "is an image and has none"],
            ),
        ] {
            let report = reloaded(&old, text).expect_err(text).to_string();
            for part in parts {
                assert!(report.contains(part), "{part:?} is missing:\n{report}");
            }
        }
    }

    #[test]
    fn an_added_texture_can_be_used() {
        let old = built(LOOK, OLD);
        let file = SourceFile::new(
            "a new one",
            "a new one.wgsl",
            "/// @param k = 3\nfn userProc(k: f32) -> f32 { return k * readAttr(AO).x; }",
        );
        let library = old
            .library_with(vec![file])
            .unwrap_or_else(|e| panic!("{e}"));
        let mut new = old
            .with_library(Arc::new(library))
            .unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((old.ao_count(), new.ao_count()), (0, 1));
        new.add_node("c", "a new one").expect("known");
        assert!(new.add_node("d", "a newer one").is_err());
        new.set_output_link("A", Output::METALLIC, Some("c"))
            .expect("one number");
        let changes = new.take_changes();
        assert!(!changes.args.is_empty() && !changes.kernel);
    }

    #[test]
    fn only_textures_with_another_text_count_as_changed() {
        let old = built(LOOK, OLD);
        let mut sources = TextureSources::default();
        let changed = |sources: &TextureSources| {
            let files = old.changed_sources(sources).expect("readable");
            files
                .iter()
                .map(|f| f.name().to_owned())
                .collect::<Vec<_>>()
        };
        assert!(changed(&sources).is_empty(), "its file is gone");
        let gone = |sources: &TextureSources| old.gone_sources(sources, |_| false).count();
        assert_eq!(gone(&sources), 1);
        sources.insert("t", OLD);
        sources.insert("u", OLD);
        assert!(changed(&sources).is_empty());
        assert_eq!(gone(&sources), 0);
        sources.insert("t", &OLD.replace('*', "+"));
        assert_eq!(changed(&sources), ["t"]);
    }
}
