//! Programs: the part of the graph below some roots, in the order and with the stack slots in which the kernel
//! evaluates it.
//!
//! A program is a list of words. The first one counts the instructions; an instruction is
//!
//! | words | content |
//! |---|---|
//! | 1 | texture type in bits 0..16, result slot in bits 16..32 |
//! | 1 | offset of the node's block in the fake stack |
//! | ⌈linkable parameters / 32⌉ | bit i is set where the i-th linkable parameter is a link, or a constant in the place of an attribute |
//! | one per set bit | the link, see [`link_word`]; 2^30 for a constant in the place of an attribute |
//! | 1, only where the texture reads `AO` or `AO1` | AO slots of the node: `AO` in bits 0..8, `AO1` in bits 8..16 |
//! | ⌈(outputs - 1) / 2⌉, only where the texture has several | slots of all outputs but the first, 16 bits each; 0xffff for those that nothing reads |
//!
//! Links lie here and not in the fake stack because slot numbers differ from program to program.

use std::collections::{BTreeSet, HashMap};

use crate::attribute::{Attribute, BuiltinAttribute};
use crate::graph::{Graph, Link, NodeId};
use crate::graph_error::GraphError;
use crate::library::Library;
use crate::schedule::{self, Dag};
use crate::swizzle::Swizzle;
use crate::value::{OutputType, ParameterType};

/// A compiled program: data for the generated kernel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// The words to put into the program buffer.
    pub words: Vec<u32>,
    /// Stack slots it needs.
    pub slots_needed: u32,
    /// The slot that holds each root after the run, in their order.
    pub results: Vec<u32>,
    /// Attributes its textures read.
    pub attributes: BTreeSet<Attribute>,
    /// Bit s is set where an instruction reads AO slot s.
    pub occlusion_mask: u32,
}

/// One instruction of a program, decoded.
#[derive(Clone, Debug, PartialEq)]
pub struct Instruction {
    /// Type number of the texture.
    pub texture: usize,
    /// Stack slot of the result.
    pub slot: u32,
    /// Offset of the node's block in the fake stack.
    pub args: u32,
    /// Linked parameters by their place, and the word of each link (see [`link_word`]).
    pub links: Vec<(usize, u32)>,
    /// AO slots for `AO` and `AO1`, where the texture reads one of them.
    pub occlusion: Option<[u32; 2]>,
    /// Numbers of the outputs behind the first that are read, and the slot of each.
    pub further: Vec<(usize, u32)>,
}

impl Program {
    /// The instructions in their order, for tools that show programs. `library` is the one the program was compiled
    /// with.
    ///
    /// # Errors
    /// The words aren't a program of this library; the number is the word or instruction that can't be.
    pub fn instructions(&self, library: &Library) -> Result<Vec<Instruction>, usize> {
        let mut at = 0;
        let mut next = || {
            at += 1;
            self.words.get(at - 1).copied().ok_or(at - 1)
        };
        let mut instructions = Vec::new();
        for _ in 0..next()? {
            let head = next()?;
            let texture = library
                .textures()
                .get((head & 0xffff) as usize)
                .ok_or(instructions.len())?;
            let args = next()?;
            let linkable: Vec<usize> = (0..texture.parameters().len())
                .filter(|&i| texture.parameters()[i].ty.is_linkable())
                .collect();
            let mut masks = Vec::new();
            for _ in 0..linkable.len().div_ceil(32) {
                masks.push(next()?);
            }
            let mut links = Vec::new();
            for (place, &parameter) in linkable.iter().enumerate() {
                if masks[place / 32] >> (place % 32) & 1 == 1 {
                    let word = next()?;
                    if word != CONSTANT {
                        links.push((parameter, word));
                    }
                }
            }
            let occlusion = if texture.reads_occlusion() {
                let word = next()?;
                Some([word & 0xff, word >> 8 & 0xff])
            } else {
                None
            };
            let count = texture.outputs().len();
            let mut further = Vec::new();
            for number in (1..count).step_by(2) {
                let word = next()?;
                further.extend([(number, word & 0xffff), (number + 1, word >> 16)]);
            }
            further.retain(|&(_, slot)| slot != NOT_KEPT);
            let (texture, slot) = ((head & 0xffff) as usize, head >> 16);
            instructions.push(Instruction {
                texture,
                slot,
                args,
                links,
                occlusion,
                further,
            });
        }
        Ok(instructions)
    }
}

/// Stands in the place of a link where a parameter that would take an attribute has a constant.
const CONSTANT: u32 = 1 << 30;

/// The slot of an output that nothing reads.
pub(crate) const NOT_KEPT: u32 = 0xffff;

/// The word for a place with the width of the pixel in its last component: what has no such component gives 0, and so the hit's
/// own.
fn coordinate_word(slot: u32, swizzle: Option<Swizzle>, output: OutputType) -> u32 {
    let own = match output {
        OutputType::F32 => [0, 0, 0, 4],
        OutputType::Vec2 => [0, 1, 4, 4],
        OutputType::Vec3 => [0, 1, 2, 4],
        OutputType::Vec4 => [0, 1, 2, 3],
    };
    let selectors = match swizzle {
        None => own,
        Some(swizzle) if swizzle.components().is_empty() => own,
        Some(swizzle) if swizzle.components().len() == 4 => swizzle.selectors(),
        Some(swizzle) => {
            let [x, y, z, _] = swizzle.selectors();
            [x, y, z, 4]
        }
    };
    with_selectors(slot, selectors)
}

fn with_selectors(slot: u32, selectors: [u8; 4]) -> u32 {
    (0..4).fold(slot & 0xffff | 1 << 31, |word, i| {
        word | u32::from(selectors[i]) << (16 + 3 * i)
    })
}

/// The word that reads stack slot `slot` through the components of a swizzle. The generated kernel's `patina_link(word)` decodes it.
///
/// Bits 0..16 are the slot. Without a swizzle that is all; else bit 31 is set and four selectors of three bits
/// follow from bit 16 on: 0..=3 pick a component, 4 is the constant 0, 5 the constant 1.
pub fn link_word(slot: u32, swizzle: Option<Swizzle>) -> u32 {
    let slot = slot & 0xffff;
    match swizzle.filter(|swizzle| !swizzle.components().is_empty()) {
        None => slot,
        Some(swizzle) => with_selectors(slot, swizzle.selectors()),
    }
}

impl Graph {
    /// Compiles the part of the graph below `roots`.
    ///
    /// # Errors
    /// An image parameter below the roots without an image; more than 65,535 results at once.
    pub fn compile(&self, roots: &[NodeId]) -> Result<Program, GraphError> {
        let whole: Vec<Link> = roots.iter().copied().map(Link::from).collect();
        self.compile_links(&whole)
    }

    /// As [`Self::compile`], for outputs of nodes: results are the slots of the outputs that the links take.
    ///
    /// # Errors
    /// As [`Self::compile`]; an output that its texture doesn't have.
    pub fn compile_links(&self, roots: &[Link]) -> Result<Program, GraphError> {
        compile(self, roots)
    }
}

/// See [`Graph::compile_links`].
pub(crate) fn compile(graph: &Graph, roots: &[Link]) -> Result<Program, GraphError> {
    let sources: Vec<NodeId> = roots.iter().map(|root| root.source).collect();
    let (nodes, mut dag) = reachable(graph, &sources);
    let kept = kept_outputs(graph, &nodes, roots)?;
    dag.widths = nodes.iter().map(|node| 1 + kept[node].len()).collect();
    for &id in &nodes {
        require_images(graph, id)?;
    }
    let schedule = schedule::schedule(&dag);
    if schedule.slots_needed > u32::from(u16::MAX) {
        return Err(GraphError::TooManySlots {
            slots: schedule.slots_needed,
        });
    }
    let places: HashMap<NodeId, usize> = nodes.iter().copied().zip(0..).collect();
    let slot_of = |link: &Link| -> Result<u32, GraphError> {
        let slots = &schedule.slots[places[&link.source]];
        let number = output_number(graph, link)?;
        // The first output is always there, before those that are kept.
        let further = kept[&link.source].iter().position(|&kept| kept == number);
        Ok(slots[further.map_or(0, |at| at + 1)])
    };

    let mut program = Program {
        words: vec![nodes.len() as u32],
        slots_needed: schedule.slots_needed,
        ..Program::default()
    };
    for &at in &schedule.order {
        let node = &graph.nodes()[nodes[at].index()];
        let texture = graph.texture_of(node);
        program
            .words
            .push(node.texture as u32 | schedule.slots[at][0] << 16);
        program.words.push(node.block);
        let inputs = node.inputs.iter().zip(texture.parameters());
        let links: Result<Vec<Option<u32>>, GraphError> = inputs
            .filter(|(_, parameter)| parameter.ty.is_linkable())
            .map(|(input, parameter)| {
                let Some(link) = input.link else {
                    let constant = parameter.attribute.is_some() && input.is_set();
                    return Ok(constant.then_some(CONSTANT));
                };
                let slot = slot_of(&link)?;
                Ok(Some(match parameter.is_coordinate() {
                    true => {
                        let whole = link.swizzle.and_then(|swizzle| swizzle.whole());
                        let output = graph.link_output(link.source, whole)?;
                        coordinate_word(slot, link.swizzle, output)
                    }
                    false => link_word(slot, link.swizzle),
                }))
            })
            .collect();
        let links = links?;
        for group in links.chunks(32) {
            let mask = group.iter().enumerate().fold(0, |mask, (bit, link)| {
                mask | u32::from(link.is_some()) << bit
            });
            program.words.push(mask);
        }
        program.words.extend(links.into_iter().flatten());
        if texture.reads_occlusion() {
            program
                .words
                .push(node.occlusion[0] | node.occlusion[1] << 8);
            for (attribute, slot) in [BuiltinAttribute::AO, BuiltinAttribute::AO1]
                .into_iter()
                .zip(node.occlusion)
            {
                if texture.attributes().contains(&attribute.into()) {
                    program.occlusion_mask |= 1 << slot;
                }
            }
        }
        let further = |number: usize| {
            let kept = kept[&nodes[at]].iter().position(|&kept| kept == number);
            kept.map_or(NOT_KEPT, |place| schedule.slots[at][place + 1])
        };
        for number in (1..texture.outputs().len()).step_by(2) {
            program
                .words
                .push(further(number) | further(number + 1) << 16);
        }
        program
            .attributes
            .extend(texture.attributes().iter().cloned());
    }
    program.results = roots.iter().map(slot_of).collect::<Result<_, _>>()?;
    Ok(program)
}

fn output_number(graph: &Graph, link: &Link) -> Result<usize, GraphError> {
    match link.swizzle {
        Some(swizzle) => graph.output_number(link.source, swizzle),
        None => Ok(0),
    }
}

/// The outputs of each node that something reads, but for the first ones: ascending.
fn kept_outputs(
    graph: &Graph,
    nodes: &[NodeId],
    roots: &[Link],
) -> Result<HashMap<NodeId, Vec<usize>>, GraphError> {
    let mut kept: HashMap<NodeId, Vec<usize>> =
        nodes.iter().map(|&node| (node, Vec::new())).collect();
    let inputs = nodes
        .iter()
        .flat_map(|node| &graph.nodes()[node.index()].inputs);
    let links = inputs.filter_map(|input| input.link);
    for link in links.chain(roots.iter().copied()) {
        let number = output_number(graph, &link)?;
        let outputs = kept.entry(link.source).or_default();
        if number > 0 && !outputs.contains(&number) {
            outputs.push(number);
        }
    }
    kept.values_mut()
        .for_each(|outputs| outputs.sort_unstable());
    Ok(kept)
}

/// The nodes below the roots, roots included, and their links by place in that list.
fn reachable(graph: &Graph, roots: &[NodeId]) -> (Vec<NodeId>, Dag) {
    let mut places: HashMap<NodeId, usize> = HashMap::new();
    let mut nodes: Vec<NodeId> = Vec::new();
    let mut place_of = |id: NodeId, nodes: &mut Vec<NodeId>| {
        *places.entry(id).or_insert_with(|| {
            nodes.push(id);
            nodes.len() - 1
        })
    };
    let mut root_places: Vec<usize> = roots
        .iter()
        .map(|&root| place_of(root, &mut nodes))
        .collect();
    root_places.sort_unstable();
    root_places.dedup();
    let mut inputs: Vec<Vec<usize>> = Vec::new();
    while inputs.len() < nodes.len() {
        let node = &graph.nodes()[nodes[inputs.len()].index()];
        let mut list: Vec<usize> = Vec::new();
        for link in node.inputs.iter().filter_map(|input| input.link) {
            let place = place_of(link.source, &mut nodes);
            if !list.contains(&place) {
                list.push(place);
            }
        }
        inputs.push(list);
    }
    (
        nodes,
        Dag {
            widths: vec![1; inputs.len()],
            inputs,
            roots: root_places,
        },
    )
}

fn require_images(graph: &Graph, id: NodeId) -> Result<(), GraphError> {
    let images = graph
        .texture(id)
        .parameters()
        .iter()
        .filter(|parameter| parameter.ty == ParameterType::Image);
    for parameter in images {
        if graph.value(id, &parameter.name).is_none() {
            return Err(GraphError::MissingValue {
                node: graph.name(id).to_owned(),
                parameter: parameter.name.clone(),
            });
        }
    }
    Ok(())
}
