//! What the rays of a bundle have yet to visit.

use std::mem::MaybeUninit;

use super::{
    lanes::{Isa, Word},
    stack,
};

/// A node's children, of which all are put here before one of them is taken.
const CHILDREN: usize = 8;

// As for a single ray: a visit to a node takes one entry and leaves at most eight. But all eight places are written whether or not there is
// something for them.
const SIZE: usize = stack::SIZE + CHILDREN;

/// Room for [`Pending`]. It isn't initialised: that would take longer than some rays.
pub(super) type Memory = [[MaybeUninit<u32>; SIZE]; 2];

/// Children, each with the rays that enter it. A stack whose entries are written eight at a time without a branch: how many
/// there are is nothing that a processor could foretell.
pub(super) struct Pending<'a> {
    /// Children, and beside each its rays.
    entries: &'a mut Memory,
    top: usize,
}

impl<'a> Pending<'a> {
    pub(super) const NEW: Memory = [[MaybeUninit::uninit(); SIZE]; 2];

    #[inline(always)]
    pub(super) fn new(entries: &'a mut Memory) -> Self {
        Self { entries, top: 0 }
    }

    /// How many there are.
    #[inline(always)]
    pub(super) fn height(&self) -> usize {
        self.top
    }

    /// Puts on top those children that are in `mask`, the first on top of the others, each with its `rays`.
    ///
    /// # Safety
    /// There is room for eight.
    #[inline(always)]
    pub(super) unsafe fn push<S: Isa>(
        &mut self,
        isa: S,
        children: &[u32; CHILDREN],
        rays: &[u32; CHILDREN],
        mask: u32,
    ) {
        debug_assert!(self.top + CHILDREN <= SIZE);
        for (to, from) in self.entries.iter_mut().zip([children, rays]) {
            // SAFETY: the caller has made sure that there is room, and integers may be written where nothing is yet.
            let to = unsafe { &mut *to.as_mut_ptr().add(self.top).cast::<[Word; CHILDREN]>() };
            isa.last_first(from, mask, to);
        }
        self.top += mask.count_ones() as usize;
    }

    /// Takes off what is on top, above `floor`.
    #[inline(always)]
    pub(super) fn pop(&mut self, floor: usize) -> Option<(u32, u32)> {
        if self.top <= floor {
            return None;
        }
        self.top -= 1;
        debug_assert!(self.top < SIZE);
        let [children, rays] = &*self.entries;
        // SAFETY: what is below `top` has been written.
        unsafe {
            Some((
                children.get_unchecked(self.top).assume_init(),
                rays.get_unchecked(self.top).assume_init(),
            ))
        }
    }
}
