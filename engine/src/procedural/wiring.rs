//! What drives each material, and its compilation into the program memory.

use std::collections::HashSet;

use texgen::{Graph, GraphError, Link, NodeId, Program, link_word};

use super::memory::{
    FLAG_BLEND, FLAG_CONSTANT_MASK, HEAD_AO, HEAD_BASE, HEAD_BUMP_PROGRAM, HEAD_BUMP_SCALE,
    HEAD_EMISSION, HEAD_FLAGS, HEAD_MASK, HEAD_MASK_VALUE, HEAD_MORE, HEAD_OPACITY, HEAD_OVER,
    HEAD_PROGRAM,
};
use super::traits::Surface;
use super::{
    HEAD_LINKS, Kind, MAX_STACK_SLOTS, MIN_STACK_SLOTS, NO_NODE, NodeOutput, Output, Outputs,
    Procedural,
};

/// What drives one material: see [`Self::output`] for a surface, `blend` for a blend of others.
#[derive(Debug, Clone, Default)]
pub(super) struct Wiring {
    /// By number.
    outputs: [Option<NodeOutput>; Output::ALL.len()],
    pub(super) blend: Option<Blend>,
    /// What the material is without its nodes.
    pub(super) surface: Surface,
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
    Driven(NodeOutput),
}

impl Wiring {
    /// Nothing is driven.
    pub(super) fn new(surface: Surface) -> Self {
        Self {
            surface,
            ..Self::default()
        }
    }

    /// What drives an output.
    pub(super) fn output(&self, output: Output) -> Option<NodeOutput> {
        self.driven().find(|(o, _)| *o == output).map(|(_, s)| s)
    }

    /// Drives an output, or no longer.
    pub(super) fn set_output(&mut self, output: Output, source: Option<NodeOutput>) {
        self.outputs[output.number() as usize] = source;
    }

    /// What drives the mask, where a node does.
    pub(super) fn mask(&self) -> Option<&NodeOutput> {
        match &self.blend.as_ref()?.mask {
            Mask::Driven(source) => Some(source),
            Mask::Constant(_) => None,
        }
    }

    /// The driven outputs, in the order of their numbers.
    fn driven(&self) -> impl Iterator<Item = (Output, NodeOutput)> {
        (Output::ALL.into_iter())
            .zip(self.outputs)
            .filter_map(|(output, source)| Some((output, source?)))
    }

    /// The outputs of nodes that the program gives, each once. The bump height isn't among them: it has its own.
    pub(super) fn roots(&self) -> Vec<Link> {
        let mask = self.mask();
        let mut roots: Vec<Link> = Vec::new();
        let driven = self.driven().filter(|(output, _)| *output != Output::BUMP);
        for source in driven.map(|(_, source)| source).chain(mask.copied()) {
            if !roots.contains(&source.root()) {
                roots.push(source.root());
            }
        }
        roots
    }
}

/// A material's programs that have not been stored yet.
pub(super) struct Compiled {
    material: u32,
    roots: Vec<Link>,
    program: Option<Program>,
    bump: Option<Program>,
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

/// Checks that an output can take a node's result through a swizzle; says what to do otherwise.
pub(super) fn check_driver(graph: &Graph, source: NodeOutput, kind: Kind) -> Result<(), String> {
    let given = graph
        .link_output(source.node, source.swizzle)
        .map_err(|error| error.to_string())?;
    let name = graph.name(source.node);
    let link = match source.swizzle {
        Some(swizzle) => format!("{name}{swizzle}"),
        None => name.to_owned(),
    };
    match (kind, given.components()) {
        (Kind::Scalar, 1) | (Kind::Color, 1 | 3 | 4) | (Kind::Vector, 3 | 4) => Ok(()),
        (Kind::Scalar, _) => {
            let output = source.swizzle.and_then(|swizzle| swizzle.whole());
            let output = output.map_or_else(String::new, |output| output.to_string());
            Err(format!(
                "`{link}` gives {given}, but one number is needed: write \"{name}{output}.x\""
            ))
        }
        (Kind::Color, _) => Err(format!(
            "`{link}` gives {given}, but a colour is needed: one, three or four components"
        )),
        (Kind::Vector, _) => Err(format!(
            "`{link}` gives {given}, but a direction is needed: three components"
        )),
    }
}

impl Procedural {
    /// Compiles the programs of a material as it is wired now.
    pub(super) fn compile(&self, material: u32) -> Result<Compiled, CompileError> {
        let wiring = &self.wiring[material as usize];
        let roots = self.roots_of(wiring);
        let bump: Vec<Link> = (wiring.output(Output::BUMP).iter())
            .map(NodeOutput::root)
            .collect();
        Ok(Compiled {
            material,
            program: self.program(material, &roots)?,
            roots,
            bump: self.program(material, &bump)?,
        })
    }

    fn program(&self, material: u32, roots: &[Link]) -> Result<Option<Program>, CompileError> {
        if roots.is_empty() {
            return Ok(None);
        }
        let program = self.graph.compile_links(roots)?;
        if program.slots_needed > MAX_STACK_SLOTS {
            return Err(CompileError::TooManySlots {
                material: self.material_name(material).to_owned(),
                needed: program.slots_needed,
            });
        }
        Ok(Some(program))
    }

    /// Writes compiled programs and their head into the memory.
    pub(super) fn store(&mut self, compiled: Compiled) {
        let Compiled {
            material,
            roots,
            program,
            bump,
        } = compiled;
        let wiring = &self.wiring[material as usize];
        let mut nodes: Vec<NodeId> = roots.iter().map(|root| root.source).collect();
        nodes.extend(wiring.output(Output::BUMP).map(|source| source.node));
        let nodes = self.reachable(&nodes);
        let programs = || program.iter().chain(&bump);
        let own_ao = programs().fold(0, |mask, p| mask | p.occlusion_mask);
        let wiring = &mut self.wiring[material as usize];
        wiring.nodes = nodes;
        wiring.own_ao = own_ao;
        let link = |source: &NodeOutput| {
            let root = roots.iter().position(|&root| root == source.root());
            let slots = program.as_ref().map_or(&[][..], |p| &p.results);
            root.and_then(|root| slots.get(root))
                .map_or(0, |&slot| link_word(slot, source.swizzle))
        };
        let slots = |node: &NodeId| {
            program
                .as_ref()?
                .results
                .get(roots.iter().position(|&root| root == Link::from(*node))?)
        };
        let link_of = |node: &NodeId| slots(node).map_or(NO_NODE, |&slot| link_word(slot, None));
        let shown: Vec<u32> = self.shown.iter().map(link_of).collect();
        let bump_link = |source: &NodeOutput| {
            let slot = bump.as_ref().and_then(|p| p.results.first());
            slot.map_or(0, |&slot| link_word(slot, source.swizzle))
        };

        let mut set = |word: u32, value: u32| self.memory.set_head(material, word, value);
        let mut outputs = Outputs::default();
        for (output, source) in Output::ALL.into_iter().zip(&wiring.outputs) {
            let word = match (source, output) {
                (None, _) => 0,
                (Some(source), Output::BUMP) => bump_link(source),
                (Some(source), _) => link(source),
            };
            if source.is_some() {
                outputs.insert(output);
            }
            set(HEAD_LINKS + output.number(), word);
        }
        let [mut flags, more] = outputs.words();
        if let Some(blend) = &wiring.blend {
            flags = FLAG_BLEND;
            let (mask_link, mask_value) = match &blend.mask {
                Mask::Driven(source) => (link(source), 0.0),
                Mask::Constant(value) => {
                    flags |= FLAG_CONSTANT_MASK;
                    (0, *value)
                }
            };
            set(HEAD_MASK, mask_link);
            set(HEAD_BASE, blend.base);
            set(HEAD_OVER, blend.over);
            set(HEAD_MASK_VALUE, mask_value.to_bits());
        }
        let surface = &wiring.surface;
        set(HEAD_BUMP_SCALE, surface.bump_scale.to_bits());
        set(HEAD_OPACITY, surface.opacity.to_bits());
        for (word, value) in (HEAD_EMISSION..).zip(surface.emission.to_array()) {
            set(word, value.to_bits());
        }
        set(HEAD_FLAGS, flags);
        set(HEAD_MORE, more);
        for (word, program) in [(HEAD_PROGRAM, &program), (HEAD_BUMP_PROGRAM, &bump)] {
            match program {
                Some(program) => {
                    self.memory.store(material, word, &shown, &program.words);
                    self.grow_stack(program.slots_needed);
                }
                None => self.memory.set_head(material, word, 0),
            }
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

    pub(super) fn reachable(&self, roots: &[NodeId]) -> HashSet<NodeId> {
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use texgen::{Library, SourceFile, TextureType};

    use super::*;

    #[test]
    fn the_part_that_is_offered_is_one_of_the_output_that_was_meant() {
        let text = "struct S { mask: f32, color: vec3f }\nfn userProc() -> S { return S(1.0, vec3f(1.0)); }";
        let texture = TextureType::parse(SourceFile::new("t", "t.wgsl", text));
        let texture = texture.unwrap_or_else(|problems| panic!("{problems}"));
        let mut graph = Graph::new(Arc::new(Library::new(vec![texture]).expect("one texture")));
        let node = graph.add_node("a", "t", [0, 0]).expect("known");
        for swizzle in [".color", ".color.rgb"] {
            let swizzle = Some(swizzle.parse().expect("an output"));
            let refused = check_driver(&graph, NodeOutput { node, swizzle }, Kind::Scalar);
            let message = refused.expect_err("three components");
            assert!(message.ends_with("write \"a.color.x\""), "{message}");
        }
    }
}
