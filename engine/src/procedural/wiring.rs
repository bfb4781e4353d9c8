//! What drives each material, and its compilation into the program memory.

use std::collections::HashSet;

use texgen::{Graph, GraphError, NodeId, Program, link_word};

use super::memory::{
    FLAG_BLEND, FLAG_CONSTANT_MASK, HEAD_AO, HEAD_BASE, HEAD_FLAGS, HEAD_LINKS, HEAD_MASK,
    HEAD_MASK_VALUE, HEAD_OVER, HEAD_PROGRAM,
};
use super::{MAX_STACK_SLOTS, MIN_STACK_SLOTS, Output, Procedural, Source};

/// What drives one material.
#[derive(Debug, Clone, Default)]
pub(super) struct Wiring {
    pub(super) outputs: [Option<Source>; Output::ALL.len()],
    pub(super) blend: Option<Blend>,
    /// AO tables that its own program reads, one bit each.
    pub(super) own_ao: u32,
    /// The nodes of its program.
    pub(super) nodes: HashSet<NodeId>,
}

/// A blend of two materials by index.
#[derive(Debug, Clone)]
pub(super) struct Blend {
    pub(super) base: u32,
    pub(super) over: u32,
    pub(super) mask: Mask,
}

/// Share of a blend's `over`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mask {
    Constant(f32),
    Driven(Source),
}

impl Wiring {
    /// The nodes whose results are needed, each once.
    fn roots(&self) -> Vec<NodeId> {
        let mask = match &self.blend {
            Some(Blend {
                mask: Mask::Driven(source),
                ..
            }) => Some(source),
            _ => None,
        };
        let mut roots: Vec<NodeId> = Vec::new();
        for source in self.outputs.iter().flatten().chain(mask) {
            if !roots.contains(&source.node) {
                roots.push(source.node);
            }
        }
        roots
    }
}

/// A material's program that has not been stored yet.
pub(super) struct Compiled {
    material: u32,
    roots: Vec<NodeId>,
    program: Option<Program>,
}

/// Why a material has no program.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CompileError {
    /// The graph below the material is not complete.
    #[error(transparent)]
    Graph(Box<GraphError>),
    /// The program is too large for the GPU's threads.
    #[error(
        "material `{material}` needs {needed} intermediate results at once, and at most {MAX_STACK_SLOTS} are possible: \
         use fewer nodes whose results are all combined in one place"
    )]
    TooManySlots {
        /// The material.
        material: String,
        /// Slots its program would need.
        needed: u32,
    },
}

impl From<GraphError> for CompileError {
    fn from(error: GraphError) -> Self {
        Self::Graph(Box::new(error))
    }
}

/// Checks that an output (a colour, or a scalar) can take a node's result through a swizzle; says what to do
/// otherwise.
pub(super) fn check_driver(graph: &Graph, source: Source, scalar: bool) -> Result<(), String> {
    let given = graph
        .link_output(source.node, source.swizzle)
        .map_err(|error| error.to_string())?;
    let name = graph.name(source.node);
    let link = match source.swizzle {
        Some(swizzle) => format!("{name}{swizzle}"),
        None => name.to_owned(),
    };
    match (scalar, given.components()) {
        (true, 1) | (false, 1 | 3 | 4) => Ok(()),
        (true, _) => Err(format!(
            "`{link}` gives {given}, but one number is needed: write \"{name}.x\""
        )),
        (false, _) => Err(format!(
            "`{link}` gives {given}, but a colour is needed: one, three or four components"
        )),
    }
}

impl Procedural {
    /// Compiles the program of a material as it is wired now.
    pub(super) fn compile(&self, material: u32) -> Result<Compiled, CompileError> {
        let roots = self.wiring[material as usize].roots();
        if roots.is_empty() {
            return Ok(Compiled {
                material,
                roots,
                program: None,
            });
        }
        let program = self.graph.compile(&roots)?;
        if program.slots_needed > MAX_STACK_SLOTS {
            return Err(CompileError::TooManySlots {
                material: self.material_name(material).to_owned(),
                needed: program.slots_needed,
            });
        }
        Ok(Compiled {
            material,
            roots,
            program: Some(program),
        })
    }

    /// Writes a compiled program and its head into the memory.
    pub(super) fn store(&mut self, compiled: Compiled) {
        let Compiled {
            material,
            roots,
            program,
        } = compiled;
        let nodes = self.reachable(&roots);
        let wiring = &mut self.wiring[material as usize];
        wiring.nodes = nodes;
        wiring.own_ao = program.as_ref().map_or(0, |p| p.occlusion_mask);
        let link = |source: &Source| {
            let root = roots.iter().position(|&root| root == source.node);
            let slots = program.as_ref().map_or(&[][..], |p| &p.results);
            root.and_then(|root| slots.get(root))
                .map_or(0, |&slot| link_word(slot, source.swizzle))
        };

        let mut flags = 0;
        for (i, output) in (0..).zip(&wiring.outputs) {
            flags |= u32::from(output.is_some()) << i;
            self.memory
                .set_head(material, HEAD_LINKS + i, output.as_ref().map_or(0, link));
        }
        if let Some(blend) = &wiring.blend {
            flags |= FLAG_BLEND;
            let (mask_link, mask_value) = match &blend.mask {
                Mask::Driven(source) => (link(source), 0.0),
                Mask::Constant(value) => {
                    flags |= FLAG_CONSTANT_MASK;
                    (0, *value)
                }
            };
            self.memory.set_head(material, HEAD_MASK, mask_link);
            self.memory.set_head(material, HEAD_BASE, blend.base);
            self.memory.set_head(material, HEAD_OVER, blend.over);
            self.memory
                .set_head(material, HEAD_MASK_VALUE, mask_value.to_bits());
        }
        self.memory.set_head(material, HEAD_FLAGS, flags);
        match &program {
            Some(program) => {
                self.memory.store(material, &program.words);
                self.grow_stack(program.slots_needed);
            }
            None => self.memory.set_head(material, HEAD_PROGRAM, 0),
        }
    }

    /// The kernel has as many slots as the hungriest program so far, rounded up.
    fn grow_stack(&mut self, needed: u32) {
        if needed > self.stack_slots {
            self.stack_slots = needed.next_multiple_of(4).max(MIN_STACK_SLOTS);
            self.changed_kernel = true;
        }
    }

    /// Brings the AO masks of all heads up to date: a blend needs what lies below it needs.
    pub(super) fn refresh_ao_masks(&mut self) {
        for i in 0..self.order.len() {
            let material = self.order[i];
            let wiring = &self.wiring[material as usize];
            let below = wiring.blend.as_ref().map_or(0, |blend| {
                self.memory.head(blend.base, HEAD_AO) | self.memory.head(blend.over, HEAD_AO)
            });
            self.memory
                .set_head(material, HEAD_AO, wiring.own_ao | below);
        }
    }

    fn reachable(&self, roots: &[NodeId]) -> HashSet<NodeId> {
        let mut seen = HashSet::new();
        let mut open = roots.to_vec();
        while let Some(node) = open.pop() {
            if seen.insert(node) {
                let parameters = self.graph.texture(node).parameters().iter();
                let links = parameters.filter_map(|p| self.graph.link(node, &p.name));
                open.extend(links.map(|link| link.source));
            }
        }
        seen
    }

    /// The name that the look uses for a material or for the surface of one.
    pub(super) fn material_name(&self, material: u32) -> &str {
        self.material_names
            .iter()
            .chain(&self.surface_names)
            .find(|&(_, &index)| index == material)
            .map_or("", |(name, _)| name)
    }
}
