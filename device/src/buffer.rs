//! Memory that kernels read and write.

use crate::native;

/// What a buffer is for. All can be written, cleared, copied and read back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Usage {
    /// `var<storage>`.
    Storage,
    /// `var<uniform>`, and `var<storage>`.
    Uniform,
    /// `var<storage>`, and sizes of dispatches.
    Indirect,
}

/// Memory on a device. Clones share it.
#[derive(Debug, Clone)]
pub struct Buffer {
    pub(crate) size: u64,
    pub(crate) memory: Memory,
}

#[derive(Debug, Clone)]
pub(crate) enum Memory {
    Gpu(wgpu::Buffer),
    Native(native::buffer::Buffer),
}

impl Buffer {
    /// Bytes, a multiple of 16.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Begins to fetch what lies at byte `offset` into the caches of the calling thread's core, if kernels run there; nothing
    /// happens elsewhere, and where there is no such byte.
    #[inline]
    pub fn prefetch(&self, offset: u64) {
        if let Memory::Native(buffer) = &self.memory {
            buffer.prefetch(offset);
        }
    }

    /// The words at byte `offset`, if kernels run on the processor and they are there.
    #[inline]
    pub fn peek<const N: usize>(&self, offset: u64) -> Option<[u32; N]> {
        match &self.memory {
            Memory::Native(buffer) => buffer.peek(offset),
            Memory::Gpu(_) => None,
        }
    }

    /// That of a driver. Buffers are used with the device that made them.
    pub(crate) fn gpu(&self) -> &wgpu::Buffer {
        match &self.memory {
            Memory::Gpu(buffer) => buffer,
            Memory::Native(_) => unreachable!("a buffer is used with the device that made it"),
        }
    }

    /// That of the processor.
    pub(crate) fn native(&self) -> &native::buffer::Buffer {
        match &self.memory {
            Memory::Native(buffer) => buffer,
            Memory::Gpu(_) => unreachable!("a buffer is used with the device that made it"),
        }
    }
}
