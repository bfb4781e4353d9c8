//! What a kernel wants to have bound.

use naga::ScalarKind;

/// A global or a function of the text that has to be bound.
#[derive(Debug, Clone, PartialEq, Hash)]
pub struct Binding {
    /// Its name in the text.
    pub name: String,
    /// `@group`; 0 for a function.
    pub group: u32,
    /// `@binding`; 0 for a function.
    pub binding: u32,
    /// What it is.
    pub kind: BindingKind,
}

/// What kernels do with a resource.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Access {
    /// It is read only.
    Read,
    /// It may be written.
    Write,
}

/// What a binding takes.
#[derive(Debug, Clone, Copy, PartialEq, Hash)]
pub enum BindingKind {
    /// Storage or uniform.
    Buffer {
        /// Whether the text may write it.
        access: Access,
        /// The fewest bytes that it must have; with a runtime-sized array that is one element of it.
        least_bytes: u32,
        /// Of a runtime-sized array: the byte at which it starts, and bytes from element to element.
        array: Option<(u32, u32)>,
    },
    /// A two-dimensional texture, sampled or storage.
    Image {
        /// Whether the text may write it.
        access: Access,
        /// Whether it has layers.
        arrayed: bool,
        /// What a texel's numbers are.
        scalar: ScalarKind,
    },
    /// A function that is called in place of the text's.
    Function {
        /// Words of its arguments and of its result.
        words: [usize; 2],
    },
}
