//! Kernels and functions that were compiled with the program, from the same text by way of the same representation between.

use kernel_ir::ir::{Function, Program};

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

/// A function that is machine code already, for kernels that are compiled at run time and call it.
#[derive(Debug, Clone, Copy)]
pub struct AheadFunction {
    key: u128,
    /// Parameters, instructions, values: most functions differ from it in these, and need no key.
    shape: [usize; 3],
    address: unsafe extern "C" fn(),
}

impl AheadFunction {
    /// What stands for the function of this [key](Program::function_key), with as many parameters, instructions and
    /// values.
    ///
    /// # Safety
    /// The address is that of a function with the parameters of the one with this key, by the platform's convention for C,
    /// which does what that function does, and needs nothing of the processor that it doesn't have.
    pub const unsafe fn new(key: u128, shape: [usize; 3], address: unsafe extern "C" fn()) -> Self {
        Self {
            key,
            shape,
            address,
        }
    }

    #[cfg_attr(
        target_family = "wasm",
        expect(dead_code, reason = "no machine code is linked there")
    )]
    pub(super) fn address(&self) -> *const u8 {
        self.address as *const u8
    }
}

/// Numbers of a function that are quickly compared.
fn shape(function: &Function) -> [usize; 3] {
    [
        function.parameters.len(),
        function.instructions.len(),
        function.value_types.len(),
    ]
}

/// The one that stands for a function of a program.
pub(super) fn find_function(
    program: &Program,
    index: usize,
    ahead: &'static [AheadFunction],
) -> Option<&'static AheadFunction> {
    let shape = shape(&program.functions[index]);
    let mut alike = ahead.iter().filter(|known| known.shape == shape).peekable();
    alike.peek()?;
    let key = program.function_key(index);
    alike.find(|known| known.key == key)
}
