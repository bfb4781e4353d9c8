//! Stands in for `link` where machine code can't be put into memory and run: WebAssembly has no such memory. There, kernels
//! are for other devices.

use cranelift_codegen::isa::OwnedTargetIsa;

use super::{Part, refused};
use crate::native::compile::{CompileError, dispatch::EntryPoint, ir::Program};

/// There is none.
#[derive(Debug)]
pub(in super::super) enum Code {}

impl Code {
    pub(in super::super) fn entry(&self) -> EntryPoint {
        match *self {}
    }
}

pub(super) fn link(_: &Program, _: Vec<Part>, _: OwnedTargetIsa) -> Result<Code, CompileError> {
    let why = "this program runs where no other code can be made to run";
    Err(refused("the kernel", why))
}
