//! What a ray has yet to visit, the nearest on top.

use std::mem::MaybeUninit;

use super::super::build::MAX_DEPTH;

// A node leaves at most seven of its children on the stack, and its nearest is written before it is taken off. Both levels
// are at most `MAX_DEPTH` deep, which their builder sees to.
const SIZE: usize = 2 * (7 * MAX_DEPTH + 1);

/// Room for a stack. It isn't initialised: that would take longer than some rays.
pub(super) type Memory = MaybeUninit<([MaybeUninit<u32>; SIZE], [MaybeUninit<f32>; SIZE])>;

/// Children, each with the distance at which the ray enters it.
pub(super) struct Stack<'a> {
    children: &'a mut [MaybeUninit<u32>; SIZE],
    distances: &'a mut [MaybeUninit<f32>; SIZE],
    top: usize,
}

impl<'a> Stack<'a> {
    #[inline(always)]
    pub(super) fn new(memory: &'a mut Memory) -> Self {
        // SAFETY: arrays of what may be uninitialised.
        let (children, distances) = unsafe { memory.assume_init_mut() };
        Self {
            children,
            distances,
            top: 0,
        }
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
            let (distance, child) = unsafe {
                (
                    self.distances.get_unchecked(self.top).assume_init(),
                    self.children.get_unchecked(self.top).assume_init(),
                )
            };
            if distance <= t_max {
                return Some(child);
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
        let (to_children, to_distances) = unsafe {
            (
                self.children.as_mut_ptr().cast::<u32>().add(self.top),
                self.distances.as_mut_ptr().cast::<f32>().add(self.top),
            )
        };
        let count = mask.count_ones() as usize;
        self.top += count - 1;
        if count == 2 {
            let a = mask.trailing_zeros() as usize & 7;
            let b = (mask & (mask - 1)).trailing_zeros() as usize & 7;
            let (near, far) = if distances[a] < distances[b] {
                (a, b)
            } else {
                (b, a)
            };
            // SAFETY: as above.
            unsafe {
                *to_distances = distances[far];
                *to_children = children[far];
            }
            return children[near];
        }
        let mut rest = mask;
        let mut placed = 0;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize & 7;
            rest &= rest - 1;
            let distance = distances[lane];
            let mut at = placed;
            // SAFETY: as above; `at` is at most `placed`, and that below eight.
            unsafe {
                while at > 0 && *to_distances.add(at - 1) < distance {
                    *to_distances.add(at) = *to_distances.add(at - 1);
                    *to_children.add(at) = *to_children.add(at - 1);
                    at -= 1;
                }
                *to_distances.add(at) = distance;
                *to_children.add(at) = children[lane];
            }
            placed += 1;
        }
        // SAFETY: the last of those that have been written.
        unsafe { *to_children.add(count - 1) }
    }
}
