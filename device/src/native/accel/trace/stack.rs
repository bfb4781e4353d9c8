//! What a ray has yet to visit, the nearest on top.

use std::mem::MaybeUninit;

use super::super::build::MAX_DEPTH;

// A node leaves at most seven of its children on the stack, and its nearest is written before it is taken off. Both levels
// are at most `MAX_DEPTH` deep, which their builder sees to.
pub(super) const SIZE: usize = 2 * (7 * MAX_DEPTH + 1);

/// Room for a stack. It isn't initialised: that would take longer than some rays.
pub(super) type Memory = [MaybeUninit<u64>; SIZE];

/// Children, each with the distance at which the ray enters it.
pub(super) struct Stack<'a> {
    entries: &'a mut Memory,
    top: usize,
}

/// The first child in `mask`, and takes it out: child and distance in one number, which is in the order of distances that aren't
/// negative. By those that are, only speed suffers.
#[inline(always)]
fn next_entry(mask: &mut u32, children: &[u32; 8], distances: &[f32; 8]) -> u64 {
    let lane = mask.trailing_zeros() as usize & 7;
    *mask &= mask.wrapping_sub(1);
    u64::from(distances[lane].to_bits()) << 32 | u64::from(children[lane])
}

impl<'a> Stack<'a> {
    pub(super) const NEW: Memory = [MaybeUninit::uninit(); SIZE];

    #[inline(always)]
    pub(super) fn new(entries: &'a mut Memory) -> Self {
        Self { entries, top: 0 }
    }

    /// How many there are.
    #[inline(always)]
    pub(super) fn height(&self) -> usize {
        self.top
    }

    /// Takes off the nearest that is above `floor` and within `t_max`, and drops what is farther.
    #[inline(always)]
    pub(super) fn pop(&mut self, floor: usize, t_max: f32) -> Option<u32> {
        while self.top > floor {
            self.top -= 1;
            debug_assert!(self.top < SIZE);
            // SAFETY: what is below `top` has been written, by `push_sorted`.
            let entry = unsafe { self.entries.get_unchecked(self.top).assume_init() };
            if f32::from_bits((entry >> 32) as u32) <= t_max {
                return Some(entry as u32);
            }
        }
        None
    }

    /// Puts the children in `mask`, two at least, onto the stack, the nearest on top, and takes that off.
    ///
    /// # Safety
    /// There is room for seven, and for an eighth for a moment.
    #[inline(always)]
    pub(super) unsafe fn push_sorted(
        &mut self,
        children: &[u32; 8],
        distances: &[f32; 8],
        mask: u32,
    ) -> u32 {
        debug_assert!(self.top + 8 <= SIZE);
        // SAFETY: the caller has made sure that there is room for the at most eight that are written.
        let to = unsafe { self.entries.as_mut_ptr().cast::<u64>().add(self.top) };
        let mut rest = mask;
        let a = next_entry(&mut rest, children, distances);
        let b = next_entry(&mut rest, children, distances);
        let (near, far) = if a < b { (a, b) } else { (b, a) };
        // SAFETY: as above.
        unsafe { to.write(far) };
        if rest == 0 {
            self.top += 1;
            return near as u32;
        }
        // SAFETY: as above.
        unsafe { to.add(1).write(near) };
        let mut placed = 2;
        loop {
            let entry = next_entry(&mut rest, children, distances);
            let mut at = placed;
            // SAFETY: as above; `at` is at most `placed`, and that below eight.
            unsafe {
                while at > 0 && to.add(at - 1).read() < entry {
                    to.add(at).write(to.add(at - 1).read());
                    at -= 1;
                }
                to.add(at).write(entry);
            }
            if rest == 0 {
                break;
            }
            placed += 1;
        }
        self.top += placed;
        // SAFETY: the last of those that have been written.
        unsafe { to.add(placed).read() as u32 }
    }

    /// Puts the children in `mask`, one at least, onto the stack, the first on top, and takes that off.
    ///
    /// # Safety
    /// There is room for seven.
    #[inline(always)]
    pub(super) unsafe fn push_in_order(
        &mut self,
        children: &[u32; 8],
        distances: &[f32; 8],
        mask: u32,
    ) -> u32 {
        debug_assert!(self.top + 7 <= SIZE);
        let first = mask.trailing_zeros() as usize & 7;
        let mut rest = mask & mask.wrapping_sub(1);
        while rest != 0 {
            let lane = 31 - rest.leading_zeros();
            rest ^= 1 << lane;
            let lane = lane as usize & 7;
            let entry = u64::from(distances[lane].to_bits()) << 32 | u64::from(children[lane]);
            // SAFETY: the caller has made sure that there is room.
            unsafe { self.entries.get_unchecked_mut(self.top).write(entry) };
            self.top += 1;
        }
        children[first]
    }
}
