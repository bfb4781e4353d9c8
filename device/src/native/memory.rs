//! Memory that rays and kernels read all over, in large pages where the system has them. An address whose page isn't in the
//! processor's table takes as long as a read from memory, or several; of usual pages of 4 KiB the table holds a few megabytes.
//!
//! What is large is mapped for itself: the allocator's memory may have been in use before, and then consists of usual pages.

use std::{
    alloc::{Layout, alloc_zeroed, dealloc},
    fmt,
    marker::PhantomData,
    ops::{Deref, DerefMut},
    ptr::NonNull,
};

use bytemuck::Pod;
use memmap2::MmapMut;

/// Where memory starts: at a line of the cache, which vectors of any width may be read from.
pub(super) const ALIGNMENT: usize = 64;

/// A large page of x86-64, and the usual one of 64-bit ARM. What is smaller gets none.
const LARGE: usize = 2 << 20;

/// Bytes that were zeros at first. What is in them is the owner's affair.
pub(super) struct Memory {
    start: NonNull<u8>,
    bytes: usize,
    /// What they lie in, if they are mapped; else they are allocated.
    map: Option<MmapMut>,
}

// SAFETY: the bytes are its own, wherever it is.
unsafe impl Send for Memory {}
// SAFETY: it lets nobody read or write them.
unsafe impl Sync for Memory {}

impl Memory {
    /// `None` if there is no memory for so many.
    pub(super) fn new(bytes: usize) -> Option<Self> {
        let layout = Self::layout(bytes)?;
        let mut map = (bytes >= LARGE).then(|| map(bytes)).flatten();
        let start = match &mut map {
            Some(map) => NonNull::new(map.as_mut_ptr()),
            // SAFETY: the layout isn't empty.
            None => NonNull::new(unsafe { alloc_zeroed(layout) }),
        };
        Some(Self {
            start: start?,
            bytes,
            map,
        })
    }

    /// The first of them, aligned to [`ALIGNMENT`].
    #[inline(always)]
    pub(super) fn start(&self) -> NonNull<u8> {
        self.start
    }

    fn layout(bytes: usize) -> Option<Layout> {
        // Never empty, so that there is always a word which an index can be restricted to.
        Layout::from_size_align(bytes.max(16), ALIGNMENT).ok()
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        if self.map.is_some() {
            return;
        }
        let layout = Self::layout(self.bytes).expect("it was allocated with this layout");
        // SAFETY: allocated in `new` with the same layout; nobody else has it any more.
        unsafe { dealloc(self.start.as_ptr(), layout) };
    }
}

/// Zeros in pages of their own, large ones if there are some.
fn map(bytes: usize) -> Option<MmapMut> {
    // Whole large pages: other sizes, Linux maps to where none begins.
    let map = MmapMut::map_anon(bytes.checked_next_multiple_of(LARGE)?).ok()?;
    // Where it can't be done, nothing but time is lost.
    #[cfg(target_os = "linux")]
    let _ = map.advise(memmap2::Advice::HugePage);
    Some(map)
}

/// So many values, zeros at first.
pub(super) struct Values<T> {
    memory: Memory,
    length: usize,
    holds: PhantomData<T>,
}

impl<T: Pod> Values<T> {
    /// `None` if there is no memory for them.
    pub(super) fn zeroed(length: usize) -> Option<Self> {
        const { assert!(align_of::<T>() <= ALIGNMENT) };
        let bytes = length.checked_mul(size_of::<T>())?;
        Some(Self {
            memory: Memory::new(bytes)?,
            length,
            holds: PhantomData,
        })
    }

    /// The same ones once more; `None` if there is no memory for them.
    pub(super) fn copied(&self) -> Option<Self> {
        let mut copy = Self::zeroed(self.length)?;
        copy.copy_from_slice(self);
        Some(copy)
    }
}

impl<T: Pod> Default for Values<T> {
    fn default() -> Self {
        Self::zeroed(0).expect("there is memory for nothing")
    }
}

impl<T: Pod> Deref for Values<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: so many values fit, any bytes are such values, and who writes them has the only reference.
        unsafe { std::slice::from_raw_parts(self.memory.start.cast().as_ptr(), self.length) }
    }
}

impl<T: Pod> DerefMut for Values<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        // SAFETY: as above.
        unsafe { std::slice::from_raw_parts_mut(self.memory.start.cast().as_ptr(), self.length) }
    }
}

impl<T: Pod> Clone for Values<T> {
    /// # Panics
    /// If there is no memory for them.
    fn clone(&self) -> Self {
        let length = self.length;
        self.copied()
            .unwrap_or_else(|| panic!("no memory is left for {length} values"))
    }
}

impl<T> fmt::Debug for Values<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Values")
            .field("length", &self.length)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_and_many_are_the_same() {
        for length in [0, 3, LARGE / 8 - 1, LARGE / 8, 5 * LARGE / 8 + 7] {
            let mut values = Values::<u64>::zeroed(length).expect("memory");
            assert!(values.len() == length && values.iter().all(|&value| value == 0));
            if let Some(last) = values.last_mut() {
                *last = 7;
            }
            let copy = values.clone();
            assert_eq!(copy.last(), (length > 0).then_some(&7));
            assert_eq!(copy.len(), length);
        }
        assert!(Values::<u64>::zeroed(1 << 59).is_none());
    }

    #[test]
    fn it_begins_at_a_line_of_the_cache() {
        for bytes in [1, 100, LARGE, LARGE + 1] {
            let memory = Memory::new(bytes).expect("memory");
            assert_eq!(memory.start().addr().get() % ALIGNMENT, 0);
        }
        assert!(Memory::new(usize::MAX - 8).is_none());
    }
}
