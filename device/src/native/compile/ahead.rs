//! Kernels that were compiled with the program, from the same text by way of the same representation between.

use kernel_ir::ir::Program;

use super::EntryPoint;

/// A kernel that is machine code already.
#[derive(Debug, Clone, Copy)]
pub struct Ahead {
    key: u128,
    entry: EntryPoint,
}

impl Ahead {
    /// What stands for the program of this [key](Program::key).
    ///
    /// # Safety
    /// The entry point does what that program does, and needs nothing of the processor that it doesn't have.
    pub const unsafe fn new(key: u128, entry: EntryPoint) -> Self {
        Self { key, entry }
    }
}

/// The one that stands for a program.
pub(super) fn find(program: &Program, ahead: &[Ahead]) -> Option<EntryPoint> {
    if ahead.is_empty() {
        return None;
    }
    let key = program.key();
    (ahead.iter().find(|kernel| kernel.key == key)).map(|kernel| kernel.entry)
}
