//! Live edits: values, links, AO. Each is a few words that the renderer writes again; none makes a shader, unless a
//! program outgrows the kernel's stack.

use texgen::{Edit, GraphError, NodeId, Value, did_you_mean};

use crate::scene::look::{AoSettings, Link, link_text};

use super::wiring::{CompileError, Compiled, Wiring, check_driver};
use super::{Kind, NodeOutput, Output, Procedural};

/// Why an edit was refused. Nothing has changed then.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    /// No node, material or AO table of that name.
    #[error("there is no {what} called `{name}`{}", hint(.suggestion))]
    Unknown {
        /// What was looked for.
        what: &'static str,
        /// As asked for.
        name: String,
        /// A name it may have meant.
        suggestion: Option<String>,
    },
    /// A link that can't be understood, or whose type doesn't fit.
    #[error("{0}")]
    Link(String),
    /// A written argument that the parameter doesn't take.
    #[error("`{parameter}` = `{text}`: {message}")]
    Argument {
        /// The parameter.
        parameter: String,
        /// As written.
        text: String,
        /// What is wrong, and what to write.
        message: String,
    },
    /// AO settings out of range.
    #[error("AO needs a distance greater than 0 and 1 to 255 samples")]
    AoSettings,
    /// The material is a blend and has no surface.
    #[error("`{material}` is a blend: drive the materials it is made of")]
    Blend {
        /// The material.
        material: String,
    },
    /// The graph refused it.
    #[error(transparent)]
    Graph(Box<GraphError>),
    /// The changed program can't be run.
    #[error(transparent)]
    Compile(#[from] CompileError),
}

impl From<GraphError> for EditError {
    fn from(error: GraphError) -> Self {
        Self::Graph(Box::new(error))
    }
}

fn hint(suggestion: &Option<String>) -> String {
    suggestion
        .as_ref()
        .map_or(String::new(), |name| format!("; did you mean `{name}`?"))
}

impl Procedural {
    /// Sets a parameter to a constant, in place of any link.
    ///
    /// # Errors
    /// Unknown node or parameter; a value of another type, or not finite.
    pub fn set_value(
        &mut self,
        node: &str,
        parameter: &str,
        value: Value,
    ) -> Result<(), EditError> {
        let node = self.node(node)?;
        let edit = self.graph.set_value(node, parameter, value)?;
        self.finish(node, &edit).map_err(EditError::from)
    }

    /// Links a parameter to another node's result: `"rust_mask"`, or some of its components: `"rust_mask.x"`.
    ///
    /// # Errors
    /// Unknown names; a type that doesn't fit; a circle; a node below without its image.
    pub fn set_link(&mut self, node: &str, parameter: &str, link: &str) -> Result<(), EditError> {
        let node = self.node(node)?;
        let source = self.source(link)?;
        let former = self.graph.link(node, parameter);
        let edit = self
            .graph
            .set_link(node, parameter, source.node, source.swizzle)?;
        if let Err(error) = self.finish(node, &edit) {
            self.restore_link(node, parameter, former);
            return Err(error.into());
        }
        Ok(())
    }

    /// Takes a link away: the parameter has its constant again.
    ///
    /// # Errors
    /// Unknown node or parameter.
    pub fn clear_link(&mut self, node: &str, parameter: &str) -> Result<(), EditError> {
        let node = self.node(node)?;
        let edit = self.graph.clear_link(node, parameter)?;
        self.finish(node, &edit).map_err(EditError::from)
    }

    /// Changes how an AO table is traced.
    ///
    /// # Errors
    /// Unknown name; settings out of range.
    pub fn set_ao(&mut self, name: &str, settings: AoSettings) -> Result<(), EditError> {
        let slot = self.ao_slot(name)?;
        let is_valid = settings.distance > 0.0 && settings.distance.is_finite();
        if !is_valid || !(1..=255).contains(&settings.samples) {
            return Err(EditError::AoSettings);
        }
        self.changed_ao |= self.ao[slot as usize] != settings;
        self.ao[slot as usize] = settings;
        Ok(())
    }

    /// Chooses the AO tables that a node's texture reads as `AO` and `AO1`.
    pub(super) fn set_occlusion_slots(
        &mut self,
        node: NodeId,
        slots: [u32; 2],
    ) -> Result<(), EditError> {
        let edit = self.graph.set_occlusion(node, slots)?;
        self.finish(node, &edit).map_err(EditError::from)
    }

    /// Drives an output of a material by a node's result; `None` gives it its constant back (an emission that the look
    /// drove has none: it is black then).
    ///
    /// # Errors
    /// Unknown names; a type that doesn't fit; the material is a blend.
    pub fn set_output_link(
        &mut self,
        material: &str,
        output: Output,
        link: Option<&str>,
    ) -> Result<(), EditError> {
        let index = match self.surface_names.get(material) {
            Some(&surface) => surface,
            None => self.material(material)?,
        };
        if self.wiring[index as usize].blend.is_some() {
            return Err(EditError::Blend {
                material: material.to_owned(),
            });
        }
        let source = link
            .map(|link| self.driver(link, output.kind()))
            .transpose()?;
        self.rewire(index, |wiring| wiring.set_output(output, source))
    }

    pub(super) fn node(&self, name: &str) -> Result<NodeId, EditError> {
        self.graph.node(name).ok_or_else(|| {
            let names = self.graph.ids().map(|id| self.graph.name(id));
            unknown("node", name, did_you_mean(name, names))
        })
    }

    fn material(&self, name: &str) -> Result<u32, EditError> {
        self.material_names.get(name).copied().ok_or_else(|| {
            let near = did_you_mean(name, self.material_names.keys().map(String::as_str));
            unknown("material", name, near)
        })
    }

    pub(super) fn ao_slot(&self, name: &str) -> Result<u32, EditError> {
        let found = self.ao_names.iter().position(|n| n == name);
        found.map(|slot| slot as u32).ok_or_else(|| {
            let near = did_you_mean(name, self.ao_names.iter().map(String::as_str));
            unknown("AO table", name, near)
        })
    }

    fn source(&self, link: &str) -> Result<NodeOutput, EditError> {
        let Link { node, swizzle } = link_text(link).map_err(EditError::Link)?;
        let node = self.node(&node)?;
        Ok(NodeOutput { node, swizzle })
    }

    fn driver(&self, link: &str, kind: Kind) -> Result<NodeOutput, EditError> {
        let source = self.source(link)?;
        check_driver(&self.graph, source, kind).map_err(EditError::Link)?;
        Ok(source)
    }

    /// Changes the wiring of one material and compiles it; on an error it is as before.
    fn rewire(&mut self, material: u32, change: impl FnOnce(&mut Wiring)) -> Result<(), EditError> {
        let wiring = &mut self.wiring[material as usize];
        let former = wiring.clone();
        change(wiring);
        match self.compile(material) {
            Ok(compiled) => {
                self.store_all([compiled]);
                Ok(())
            }
            Err(error) => {
                self.wiring[material as usize] = former;
                Err(error.into())
            }
        }
    }

    /// Notes which words an edit of the graph changed and compiles the programs that contain the node, if they must be.
    pub(super) fn finish(&mut self, node: NodeId, edit: &Edit) -> Result<(), CompileError> {
        self.note_args(node, edit);
        if !edit.program {
            return Ok(());
        }
        let affected = (0..)
            .zip(&self.wiring)
            .filter(|(_, w)| w.nodes.contains(&node));
        let affected: Vec<u32> = affected.map(|(material, _)| material).collect();
        let compiled: Result<Vec<_>, _> = affected.into_iter().map(|m| self.compile(m)).collect();
        self.store_all(compiled?);
        Ok(())
    }

    pub(super) fn store_all(&mut self, programs: impl IntoIterator<Item = Compiled>) {
        for program in programs {
            self.store(program);
        }
        self.refresh_ao_masks();
        self.refresh_traits();
    }

    fn note_args(&mut self, node: NodeId, edit: &Edit) {
        self.shows_args |= self.wiring.iter().any(|w| w.nodes.contains(&node));
        for range in &edit.words {
            self.changed_args.add(range.start as u32..range.end as u32);
        }
    }

    /// Takes a refused link back. What it replaced was valid, so the graph accepts it.
    fn restore_link(&mut self, node: NodeId, parameter: &str, former: Option<texgen::Link>) {
        let edit = match former {
            Some(link) => self
                .graph
                .set_link(node, parameter, link.source, link.swizzle),
            None => self.graph.clear_link(node, parameter),
        };
        if let Ok(edit) = edit {
            self.note_args(node, &edit);
        }
    }
}

fn unknown(what: &'static str, name: &str, suggestion: Option<&str>) -> EditError {
    EditError::Unknown {
        what,
        name: name.to_owned(),
        suggestion: suggestion.map(str::to_owned),
    }
}
