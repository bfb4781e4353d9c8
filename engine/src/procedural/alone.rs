//! How often hits run each node, and programs that run one node alone: to measure what it costs.

use std::collections::BTreeMap;

use texgen::{Link, NodeId};

use super::memory::{HEAD_AO, HEAD_OPACITY, HEAD_PROGRAM};
use super::wiring::CompileError;
use super::{HEAD_WORDS, NO_NODE, NodeOutput, Output, Procedural};

/// The height of a bump map is evaluated at the hit and at two points beside it.
const BUMP_POINTS: u64 = 3;

/// Hits of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Hits {
    /// Of the surface that was hit.
    pub(crate) material: u32,
    /// The material that its blends led to.
    pub(crate) resolved: u32,
    /// How many.
    pub(crate) count: u64,
}

impl Procedural {
    /// How often hits run each node that they do run, in the order of the graph.
    pub(crate) fn count_runs(&self, hits: &[Hits]) -> Vec<(NodeId, u64)> {
        let mut runs = BTreeMap::<usize, u64>::new();
        for hits in hits {
            for material in self.chain(hits.material, hits.resolved) {
                let wiring = &self.wiring[material as usize];
                let bump = wiring.output(Output::BUMP);
                let programs: [(Vec<Link>, u64); 2] = [
                    (wiring.roots(), 1),
                    (bump.iter().map(NodeOutput::root).collect(), BUMP_POINTS),
                ];
                for (roots, times) in programs {
                    let roots: Vec<NodeId> = roots.iter().map(|root| root.source).collect();
                    for node in self.reachable(&roots) {
                        *runs.entry(node.index()).or_default() += times * hits.count;
                    }
                }
            }
        }
        let count = |node: NodeId| Some((node, *runs.get(&node.index())?));
        self.graph.ids().filter_map(count).collect()
    }

    /// The materials whose programs ran: a material, and what its blends led to.
    fn chain(&self, material: u32, resolved: u32) -> Vec<u32> {
        // What lies below a blend comes before it, so one pass is enough however blends share what they blend.
        let mut leads = vec![false; self.wiring.len()];
        for &m in &self.order {
            let blend = self.wiring[m as usize].blend.as_ref();
            let sides = blend.map(|b| leads[b.base as usize] || leads[b.over as usize]);
            leads[m as usize] = m == resolved || sides.unwrap_or(false);
        }
        let mut chain = vec![material];
        let mut at = material;
        while at != resolved
            && let Some(blend) = &self.wiring[at as usize].blend
        {
            at = match leads[blend.base as usize] {
                true => blend.base,
                false => blend.over,
            };
            chain.push(at);
        }
        chain
    }

    /// Heads, as [`Self::programs`] has them, with which no hit runs anything.
    pub(crate) fn idle_programs(&self) -> Vec<u32> {
        let mut words = vec![0; self.wiring.len() * HEAD_WORDS as usize];
        for material in 0..self.wiring.len() as u32 {
            // A hit of a surface that lets light pass asks for its opacity, whatever is driven.
            words[(material * HEAD_WORDS + HEAD_OPACITY) as usize] =
                self.memory.head(material, HEAD_OPACITY);
        }
        words
    }

    /// The same, but that every hit runs `node` alone, with constants in place of its links. Hits of materials that don't run
    /// it do so, too: the more there are, the better its time is known.
    ///
    /// # Errors
    /// The node can't be compiled; those that some program runs can be.
    pub(crate) fn programs_of(&self, node: NodeId) -> Result<Vec<u32>, CompileError> {
        let mut graph = self.graph.clone();
        let parameters = graph.texture(node).parameters().iter();
        let names: Vec<String> = parameters.map(|p| p.name.clone()).collect();
        for name in names {
            graph.clear_link(node, &name)?;
        }
        let program = graph.compile(&[node])?;
        let mut words = self.idle_programs();
        words.extend(self.shown.iter().map(|_| NO_NODE));
        let start = words.len() as u32;
        for material in 0..self.wiring.len() as u32 {
            words[(material * HEAD_WORDS + HEAD_PROGRAM) as usize] = start;
        }
        words.extend(program.words);
        Ok(words)
    }

    /// The programs as they are, but that hits ask for one AO table only.
    pub(crate) fn programs_with_ao(&self, table: u32) -> Vec<u32> {
        let heads = self.wiring.len() * HEAD_WORDS as usize;
        let mut words = self.programs().to_vec();
        for head in words[..heads].chunks_exact_mut(HEAD_WORDS as usize) {
            head[HEAD_AO as usize] &= 1 << table;
        }
        words
    }
}
