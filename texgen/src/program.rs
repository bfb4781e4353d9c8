//! Programs: the part of the graph below some roots, in the order and with the stack slots in which the kernel
//! evaluates it.
//!
//! A program is a list of words. The first one counts the instructions; an instruction is
//!
//! | words | content |
//! |---|---|
//! | 1 | texture type in bits 0..16, result slot in bits 16..32 |
//! | 1 | offset of the node's block in the fake stack |
//! | ⌈linkable parameters / 32⌉ | bit i is set where the i-th linkable parameter is a link |
//! | one per set bit | the link, see [`link_word`] |
//! | 1, only where the texture reads `AO` or `AO1` | AO slots of the node: `AO` in bits 0..8, `AO1` in bits 8..16 |
//!
//! Links lie here and not in the fake stack because slot numbers differ from program to program.

use std::collections::BTreeSet;

use crate::attribute::Attribute;
use crate::swizzle::Swizzle;

/// A compiled program: data for the generated kernel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// The words to put into the program buffer.
    pub words: Vec<u32>,
    /// Stack slots it needs.
    pub slots_needed: u32,
    /// The slot that holds each root's result after the run, in the order of the roots.
    pub results: Vec<u32>,
    /// Attributes its textures read.
    pub attributes: BTreeSet<Attribute>,
    /// Bit s is set where an instruction reads AO slot s.
    pub occlusion_mask: u32,
}

/// The word that reads stack slot `slot` through a swizzle. The generated kernel's `patina_link(word)` decodes it.
///
/// Bits 0..16 are the slot. Without a swizzle that is all; else bit 31 is set and four selectors of three bits
/// follow from bit 16 on: 0..=3 pick a component, 4 is the constant 0, 5 the constant 1.
pub fn link_word(slot: u32, swizzle: Option<Swizzle>) -> u32 {
    let slot = slot & 0xffff;
    match swizzle {
        None => slot,
        Some(swizzle) => {
            let selectors = swizzle.selectors();
            (0..4).fold(slot | 1 << 31, |word, i| {
                word | u32::from(selectors[i]) << (16 + 3 * i)
            })
        }
    }
}
