//! Nodes whose values the film keeps: every material that has one of them in its programs gives its result, too, whatever it is
//! used for.

use texgen::{Link, NodeId};

use super::edit::EditError;
use super::wiring::Wiring;
use super::{MOST_RESULT_FIELDS, Output, Procedural};

/// In the place of a node's link before a program: the material doesn't have that node. No link has such selectors.
pub const NO_NODE: u32 = u32::MAX;

/// Words of a path's results where the values of so many nodes are among them, a field each behind all others.
pub fn node_words(nodes: usize) -> u32 {
    match nodes {
        0 => 0,
        nodes => 4 * (MOST_RESULT_FIELDS + nodes as u32),
    }
}

impl Procedural {
    /// The same, with programs that give the values of these nodes besides what materials are made of.
    ///
    /// # Errors
    /// A name that no node has; a program that becomes too large by them.
    pub fn showing(&self, nodes: &[String]) -> Result<Self, EditError> {
        let mut showing = self.clone();
        let shown: Result<Vec<NodeId>, _> = nodes.iter().map(|name| self.node(name)).collect();
        showing.shown = shown?;
        if showing.shown == self.shown {
            return Ok(showing);
        }
        let materials = 0..showing.wiring.len() as u32;
        let compiled: Result<Vec<_>, _> = materials.map(|m| showing.compile(m)).collect();
        showing.store_all(compiled?);
        showing.take_changes();
        Ok(showing)
    }

    /// What a material's program has to give: what drives the material, and those of its nodes that are shown.
    pub(super) fn roots_of(&self, wiring: &Wiring) -> Vec<Link> {
        let mut roots = wiring.roots();
        if self.shown.is_empty() {
            return roots;
        }
        let bump = wiring.output(Output::BUMP).map(|source| source.node);
        let roots_of = roots.iter().map(|root| root.source);
        let own: Vec<NodeId> = roots_of.chain(bump).collect();
        let own = self.reachable(&own);
        for node in self.shown.iter().filter(|node| own.contains(node)) {
            let root = Link::from(*node);
            if !roots.contains(&root) {
                roots.push(root);
            }
        }
        roots
    }
}
