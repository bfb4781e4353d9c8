//! Procedural textures on the CPU side: a look and a directory of user textures become a texture graph, one program per
//! material, and the words that the GPU reads.
//!
//! Plain data and arithmetic: nothing here knows wgpu. The renderer uploads [`Procedural::programs`] and
//! [`Procedural::args`], compiles [`Procedural::kernel`] once, and after each edit writes the ranges that
//! [`Procedural::take_changes`] names.
//!
//! # Program memory
//! [`Procedural::programs`] begins with a head of [`HEAD_WORDS`] words for each material of the scene, by material
//! index; texgen's programs follow, each with room to grow.
//!
//! | word | content |
//! |---|---|
//! | 0 | where the program begins, in words from the start of the buffer; 0 is none |
//! | 1 | bit 31: the material is a blend, and then bit 30: the mask is a constant; else the first word of [`Outputs`] |
//! | 2 | link of the blend's mask |
//! | 3 | material index of the blend's base |
//! | 4 | material index of the blend's over |
//! | 5 | bit i: AO table i is needed by this material or by one below its blends |
//! | 6 | a constant mask, as f32 bits |
//! | 7 | where the program that gives the height begins, 0 is none |
//! | 8 | metres per unit of that height, as f32 bits |
//! | 9 | the opacity where it is a constant, as f32 bits |
//! | 10 to 12 | the emission where it is a constant, else the factor on a driven one, as f32 bits |
//! | 13 | the second word of [`Outputs`] |
//! | 14, 15 | 0 |
//! | 16 + i | link of output i |
//!
//! A link is texgen's link word: a slot of the program's results, with a swizzle. A driven output replaces the
//! constant and the glTF texture of the material. A blend has no surface of its own: its record in
//! [`Scene::materials`] is a copy of its base's without emission, for whatever must be known before
//! the program has run (alpha, sides).
//!
//! Before a program lie as many words as there are nodes whose values the film keeps ([`Procedural::showing`]): the link of each, or
//! [`NO_NODE`] where the material doesn't have it.
//!
//! The height of a bump map has a program of its own, the nodes below it alone, because it is evaluated at several
//! points around a hit.
//!
//! [`Scene::materials`]: crate::scene::Scene::materials

mod alone;
mod build;
mod documents;
mod edit;
mod images;
mod inlined;
mod materials;
mod memory;
mod probe;
mod reads;
mod recipe;
mod reload;
mod remarks;
mod showing;
mod sketch;
mod sources;
mod standard;
#[cfg(test)]
mod tests;
pub(crate) mod traits;
mod update;
mod values;
mod wiring;
pub(crate) mod written;

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use texgen::{Diagnostics, GeneratedKernel, Graph, Link, NodeId, Swizzle};

use crate::input::Files;
use crate::scene::look::{AoSettings, MAX_AO};
use crate::scene::{Material, TextureRef};
use crate::texturing::ProgramTraits;

pub use crate::material_record::{
    HEAD_LINKS, HEAD_WORDS, Kind, MOST_RESULT_FIELDS, Output, Outputs,
};
pub(crate) use alone::Hits;
pub(crate) use documents::expanded;
pub use edit::EditError;
pub use inlined::Inlined;
pub use memory::{
    FLAG_BLEND, FLAG_CONSTANT_MASK, HEAD_AO, HEAD_BASE, HEAD_BUMP_PROGRAM, HEAD_BUMP_SCALE,
    HEAD_EMISSION, HEAD_FLAGS, HEAD_MASK, HEAD_MASK_VALUE, HEAD_MORE, HEAD_OPACITY, HEAD_OVER,
    HEAD_PROGRAM,
};
pub(crate) use recipe::{MaskRecipe, Recipe, SurfaceRecipe};
pub use showing::{NO_NODE, node_words};
pub use sketch::{resketch, sketch};
pub use sources::{LIBRARIES, SourcesError, TextureSources};
pub(crate) use update::UpdateError;
pub use wiring::CompileError;

use memory::{ProgramMemory, RangeSet};
use wiring::Wiring;

/// The most stack slots a program may need: they live in the registers and private memory of each GPU thread.
pub const MAX_STACK_SLOTS: u32 = 256;

/// Slots the kernel has at least, so that wiring anew seldom needs another kernel.
const MIN_STACK_SLOTS: u32 = 8;

/// The texture graph of a scene with the memory that mirrors it on the GPU.
#[derive(Debug, Clone)]
pub struct Procedural {
    graph: Graph,
    ao: [AoSettings; MAX_AO],
    ao_names: Vec<String>,
    memory: ProgramMemory,
    wiring: Vec<Wiring>,
    traits: Vec<ProgramTraits>,
    /// All material indices, blends after what lies below them.
    order: Vec<u32>,
    material_names: HashMap<String, u32>,
    /// Where the surface of a material that blends with itself went.
    surface_names: HashMap<String, u32>,
    /// The materials without what the look's tables say.
    originals: Arc<[Material]>,
    /// The nodes whose values the film keeps.
    shown: Vec<NodeId>,
    /// So many of them are the scene's; the look added the rest.
    scene_materials: usize,
    textures: Vec<TextureRef>,
    /// Where images are that are set later.
    files: Arc<dyn Files>,
    /// Of the scene's images, ascending.
    images_with_levels: Vec<u32>,
    /// As [`texgen::Library::custom_attributes`].
    custom_attributes: Vec<String>,
    /// The materials whose meshes have tangents, as far as there are texture coordinates for them.
    along_tangents: HashSet<u32>,
    stack_slots: u32,
    changed_args: RangeSet,
    /// Some of these are of nodes that a material needs.
    shows_args: bool,
    changed_ao: bool,
    changed_kernel: bool,
    warnings: Diagnostics,
}

/// An output of a node, or some of its components.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct NodeOutput {
    node: NodeId,
    swizzle: Option<Swizzle>,
}

impl NodeOutput {
    /// The output as a whole: what a program has to give.
    fn root(&self) -> Link {
        Link {
            source: self.node,
            swizzle: self.swizzle.and_then(|swizzle| swizzle.whole()),
        }
    }
}

/// What must be written again on the GPU.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Changes {
    /// Ranges of [`Procedural::programs`], ascending; they may lie beyond the former end.
    pub programs: Vec<Range<u32>>,
    /// Ranges of [`Procedural::args`], ascending; they may lie beyond the former end.
    pub args: Vec<Range<u32>>,
    /// The AO tables.
    pub ao: bool,
    /// A program needs more stack slots than the kernel has: [`Procedural::kernel`] has to be compiled again *before*
    /// the programs are written. Seldom.
    pub kernel: bool,
}

impl Changes {
    /// Whether nothing is to be done.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl Procedural {
    /// Heads and programs; see the module's description.
    pub fn programs(&self) -> &[u32] {
        self.memory.words()
    }

    /// The fake stack: the constants of all nodes.
    pub fn args(&self) -> &[u32] {
        self.graph.args()
    }

    /// The AO tables; those from [`Self::ao_count`] on are not used.
    pub fn ao(&self) -> &[AoSettings; MAX_AO] {
        &self.ao
    }

    /// How many AO tables there are.
    pub fn ao_count(&self) -> usize {
        self.ao_names.len()
    }

    /// The names of the AO tables.
    pub fn ao_names(&self) -> &[String] {
        &self.ao_names
    }

    /// The images of `sam2D` parameters. A texture's image handle is an index into this list.
    pub fn textures(&self) -> &[TextureRef] {
        &self.textures
    }

    /// The generated kernel's text, for programs that need at most [`Self::stack_slots`] slots.
    pub fn kernel(&self) -> GeneratedKernel {
        self.graph.library().emit(self.stack_slots)
    }

    /// Whether another graph's kernel is this one's.
    pub(crate) fn has_kernel_of(&self, other: &Self) -> bool {
        let is_shared = Arc::ptr_eq(self.graph.library(), other.graph.library())
            && self.stack_slots == other.stack_slots;
        self.is_empty() == other.is_empty()
            && (is_shared || self.kernel().wgsl == other.kernel().wgsl)
    }

    /// So many materials are those of the scene's files, its first ones; the look has added the others.
    pub fn scene_materials(&self) -> usize {
        self.scene_materials
    }

    /// Stack slots of the kernel.
    pub fn stack_slots(&self) -> u32 {
        self.stack_slots
    }

    /// The texture graph.
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// Whether a material is a blend or has a driven output.
    pub fn is_procedural(&self, material: u32) -> bool {
        (material as usize) < self.wiring.len() && self.memory.head(material, HEAD_FLAGS) != 0
    }

    /// What of a material is driven; nothing of a blend.
    pub fn outputs(&self, material: u32) -> Outputs {
        match self.memory.head(material, HEAD_FLAGS) {
            flags if flags & FLAG_BLEND != 0 => Outputs::default(),
            flags => Outputs::of_words(flags, self.memory.head(material, HEAD_MORE)),
        }
    }

    /// Whether no material is procedural, so that the generated kernel need not run.
    pub fn is_empty(&self) -> bool {
        (0..self.wiring.len() as u32).all(|m| !self.is_procedural(m))
    }

    /// Words that the results of a hit take in the state of a path, for the hungriest material.
    pub fn result_words(&self) -> u32 {
        let of = |m: u32| self.outputs(m).result_words();
        let driven = (0..self.wiring.len() as u32).map(of).max().unwrap_or(0);
        // Where anything decides about opacity, all sides of a blend have one.
        let driven = driven + u32::from(self.traits.iter().any(|t| t.decides_opacity));
        driven.max(node_words(self.shown.len()))
    }

    /// What is odd in the look or in its textures, but not wrong.
    pub fn warnings(&self) -> &Diagnostics {
        &self.warnings
    }

    /// What changed since the last call (or since the build).
    pub fn take_changes(&mut self) -> Changes {
        Changes {
            programs: self.memory.take_changes(),
            args: self.changed_args.take(),
            ao: std::mem::take(&mut self.changed_ao),
            kernel: std::mem::take(&mut self.changed_kernel),
        }
    }

    /// Whether a material can show these changes, which have been taken: arguments of nodes that none needs are no matter.
    pub(crate) fn shows(&mut self, changes: &Changes) -> bool {
        let shows_args = std::mem::take(&mut self.shows_args);
        shows_args || !changes.programs.is_empty() || changes.ao || changes.kernel
    }
}
