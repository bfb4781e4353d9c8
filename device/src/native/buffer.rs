//! Memory of the native device: what kernels read and write.

use std::{
    fmt,
    sync::{
        Arc,
        atomic::{AtomicU32, Ordering},
    },
};

use bytemuck::Pod;

use super::memory::Memory;

/// 32-bit words that kernels read and write; clones share them.
///
/// Nobody ever holds a reference to plain words: the program sees them as [`AtomicU32`], kernels see them as raw memory,
/// a word at a time. So both may access a buffer at once, and what they then read is old or new, word by word, but
/// nothing is undefined. Who wants the results of a dispatch waits for its end.
#[derive(Clone)]
pub struct Buffer {
    memory: Arc<Memory>,
    words: usize,
}

/// There is not enough memory for a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("no memory is left for a buffer of {bytes} bytes")]
pub struct OutOfMemory {
    /// What was asked for.
    pub bytes: u64,
}

impl Buffer {
    /// A buffer of zeros; `bytes` is rounded up to whole words.
    ///
    /// # Errors
    /// If there is no memory for it.
    pub fn new(bytes: u64) -> Result<Self, OutOfMemory> {
        let failed = OutOfMemory { bytes };
        let words = usize::try_from(bytes.div_ceil(4)).map_err(|_| failed)?;
        let memory = words.checked_mul(4).and_then(Memory::new).ok_or(failed)?;
        Ok(Self {
            memory: Arc::new(memory),
            words,
        })
    }

    /// A buffer that holds `values`.
    ///
    /// # Errors
    /// If there is no memory for it.
    pub fn from_slice<T: Pod>(values: &[T]) -> Result<Self, OutOfMemory> {
        let buffer = Self::new(size_of_val(values) as u64)?;
        buffer.write(0, values);
        Ok(buffer)
    }

    /// Bytes in it: a multiple of four.
    pub fn size(&self) -> u64 {
        self.words as u64 * 4
    }

    /// All words of it.
    #[inline]
    pub fn words(&self) -> &[AtomicU32] {
        // SAFETY: so many words were allocated, as zeros; they live as long as `self`, and are seen as atomics alone.
        unsafe { std::slice::from_raw_parts(self.memory.start().cast().as_ptr(), self.words) }
    }

    /// Begins to fetch the word at byte `offset`, if there is one.
    #[inline]
    pub fn prefetch(&self, offset: u64) {
        #[cfg(target_arch = "x86_64")]
        if let Some(word) = self.words().get((offset / 4) as usize) {
            use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
            // SAFETY: there is such a word; nothing is read that anybody sees.
            unsafe { _mm_prefetch::<_MM_HINT_T1>(std::ptr::from_ref(word).cast()) };
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = offset;
    }

    /// The words at byte `offset`, if they are there.
    #[inline]
    pub fn peek<const N: usize>(&self, offset: u64) -> Option<[u32; N]> {
        let words = self.words().get((offset / 4) as usize..)?;
        let words = words.first_chunk::<N>()?;
        Some(words.each_ref().map(|word| word.load(Ordering::Relaxed)))
    }

    /// Copies `values` to byte `offset`. Bytes that don't fill their last word leave zeros behind them in it.
    ///
    /// # Panics
    /// If `offset` is no multiple of four, or the values don't fit.
    pub fn write<T: Pod>(&self, offset: u64, values: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        let words = self.range(offset, bytes.len().div_ceil(4));
        if let Ok(values) = bytemuck::try_cast_slice::<u8, u32>(bytes) {
            for (word, &value) in words.iter().zip(values) {
                word.store(value, Ordering::Relaxed);
            }
            return;
        }
        let chunks = bytes.chunks_exact(4);
        let rest = chunks.remainder();
        for (word, chunk) in words.iter().zip(chunks) {
            let value = u32::from_ne_bytes([chunk[0], chunk[1], chunk[2], chunk[3]]);
            word.store(value, Ordering::Relaxed);
        }
        if let (Some(word), false) = (words.last(), rest.is_empty()) {
            let mut last = [0; 4];
            last[..rest.len()].copy_from_slice(rest);
            word.store(u32::from_ne_bytes(last), Ordering::Relaxed);
        }
    }

    /// `count` values from byte `offset` on.
    ///
    /// # Panics
    /// If `offset` is no multiple of four, the size of `T` isn't, or the buffer ends before.
    pub fn read<T: Pod>(&self, offset: u64, count: usize) -> Vec<T> {
        assert!(size_of::<T>().is_multiple_of(4), "values of whole words");
        let mut values = vec![T::zeroed(); count];
        let words = self.range(offset, size_of::<T>() / 4 * count);
        if let Ok(values) = bytemuck::try_cast_slice_mut::<T, u32>(&mut values) {
            for (word, value) in words.iter().zip(values) {
                *value = word.load(Ordering::Relaxed);
            }
        } else {
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
            for (word, chunk) in words.iter().zip(bytes.chunks_exact_mut(4)) {
                chunk.copy_from_slice(&word.load(Ordering::Relaxed).to_ne_bytes());
            }
        }
        values
    }

    /// Zeros `bytes` from byte `offset` on; both are multiples of four.
    ///
    /// # Panics
    /// If they aren't, or the buffer ends before.
    pub fn clear(&self, offset: u64, bytes: u64) {
        for word in self.range(offset, whole_words(bytes)) {
            word.store(0, Ordering::Relaxed);
        }
    }

    /// Copies `bytes` from byte `offset` on to another buffer.
    ///
    /// # Panics
    /// If a place or the size is no multiple of four, or one of the buffers ends before.
    pub fn copy_to(&self, offset: u64, target: &Buffer, target_offset: u64, bytes: u64) {
        let words = whole_words(bytes);
        let from = self.range(offset, words);
        for (to, from) in target.range(target_offset, words).iter().zip(from) {
            to.store(from.load(Ordering::Relaxed), Ordering::Relaxed);
        }
    }

    fn range(&self, offset: u64, words: usize) -> &[AtomicU32] {
        let first = whole_words(offset);
        let all = self.words();
        let fits = first.checked_add(words).is_some_and(|end| end <= all.len());
        assert!(
            fits,
            "words {first} to {first} + {words} of a buffer of {}",
            all.len()
        );
        &all[first..first + words]
    }
}

fn whole_words(bytes: u64) -> usize {
    assert!(bytes.is_multiple_of(4), "whole words");
    usize::try_from(bytes / 4).expect("a place in memory")
}

impl fmt::Debug for Buffer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Buffer")
            .field("size", &self.size())
            .finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let buffer = Buffer::new(18).expect("memory");
        assert_eq!(buffer.size(), 20);
        buffer.write(4, &[1.5f32, -2.0]);
        buffer.write(12, &[7u8, 8, 9, 10, 11]);
        assert_eq!(buffer.read::<u32>(0, 1), [0]);
        assert_eq!(buffer.read::<f32>(4, 2), [1.5, -2.0]);
        assert_eq!(
            buffer.read::<[u8; 4]>(12, 2),
            [[7, 8, 9, 10], [11, 0, 0, 0]]
        );
        let other = Buffer::new(8).expect("memory");
        buffer.copy_to(4, &other, 0, 8);
        assert_eq!(other.read::<f32>(0, 2), [1.5, -2.0]);
        buffer.clear(8, 4);
        assert_eq!(buffer.read::<f32>(4, 2), [1.5, 0.0]);
    }

    #[test]
    fn too_much_is_an_error() {
        assert!(Buffer::new(u64::MAX - 8).is_err());
    }
}
