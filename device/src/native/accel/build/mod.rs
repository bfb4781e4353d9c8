//! Builds a hierarchy: a binary tree by the surface area heuristic ([`binary`]), whose nodes are then joined to nodes of
//! eight children ([`collapse`]) and come in an order that suits any-hit rays ([`order`]).

mod binary;
mod collapse;
mod order;
mod progress;
mod split;

pub(super) use order::Search;
pub use progress::BuildError;
pub(super) use progress::Progress;

use bytemuck::Pod;

use super::{
    super::memory::Values,
    bounds::{Bounds, Reference},
    layout::Node,
};

/// Most levels of nodes that a hierarchy has: the binary tree has no more, and joining its nodes adds none.
pub const MAX_DEPTH: usize = 64;

/// A hierarchy whose leaves hold `L`.
#[derive(Debug)]
pub(super) struct Hierarchy<L> {
    /// The root first; nothing where there is nothing to enclose.
    pub(super) nodes: Values<Node>,
    pub(super) leaves: Values<L>,
    pub(super) bounds: Bounds,
    /// Levels of nodes.
    pub(super) depth: usize,
    /// What an any-hit ray that meets the bounds has to expect.
    pub(super) search: Search,
}

impl<L: Pod + Send + Sync> Hierarchy<L> {
    /// Encloses what `references` refer to. A leaf holds at most `most` of them, and `leaf` makes it from their indices;
    /// `search` says what an any-hit ray has to expect of it in its box.
    ///
    /// # Errors
    /// If `progress` says that it is to end, or there is no memory for it.
    pub(super) fn build(
        mut references: Vec<Reference>,
        most: usize,
        progress: &Progress<'_>,
        leaf: impl Fn(&[u32]) -> L + Sync,
        search: impl Fn(&L, Bounds) -> Search + Sync,
    ) -> Result<Self, BuildError> {
        if references.is_empty() {
            return Ok(Self {
                nodes: Values::default(),
                leaves: Values::default(),
                bounds: Bounds::EMPTY,
                depth: 0,
                search: Search::in_leaf(0.0),
            });
        }
        let tree = binary::Tree::build(&mut references, most, progress)?;
        drop(references);
        collapse::collapse(&tree, &leaf, &search)
    }
}
