//! WGSL to machine code.
//!
//! `naga::Module` → (`lower`) → a small linear, scalar representation (`ir`) → (`generate`) →
//! machine code by Cranelift. Composites are taken apart into scalars, variables become values wherever their elements
//! aren't chosen at run time, conditions that override constants decide leave no code, and functions are inlined, but
//! for those that [`Options::separate`] names and those that are large and called often.
//!
//! **Safety.** A kernel touches nothing but its stack, the dispatch's scratch memory, and the resources that were bound:
//! every index is restricted to its array as WebGPU's implementations do it, and [`Kernel::bind`] refuses a resource
//! that is smaller than what the text declares. Machine code lies in memory that is writable or executable, never both
//! (`cranelift-jit` writes it to fresh pages, which then become executable and read-only), and what a chain of
//! functions takes of the stack is summed up and limited when they are compiled; none of them can call itself.

mod bind;
mod cache;
mod dispatch;
mod error;
#[cfg_attr(
    target_family = "wasm",
    expect(dead_code, reason = "nothing is linked")
)]
mod generate;
mod ir;
mod lower;
#[cfg_attr(
    target_family = "wasm",
    expect(dead_code, reason = "nothing is linked")
)]
mod runtime;

pub use bind::{Access, BindError, Binding, BindingKind, Resource};
pub use cache::Cache;
pub use dispatch::BoundKernel;
pub use error::{CompileError, ErrorKind};

use std::{sync::Arc, time::Duration};

use generate::Code;

/// How a kernel is compiled.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Functions that get machine code of their own, by name; the rest is inlined as far as that pays. With a
    /// [`Cache`], what these contain is compiled once, whatever changes around them.
    pub separate: &'a (dyn Fn(&str) -> bool + Sync),
    /// Functions that aren't compiled, by name: what is bound to this name is called instead ([`Resource::Function`]).
    pub host: &'a [&'static str],
    /// The most times that a loop's body runs, each time that the loop is entered; then it ends. For texts whose loops
    /// may not end.
    pub loop_limit: Option<u32>,
    /// The most bytes of stack that an invocation may take: arrays of the text's own, and what machine code needs
    /// beside them.
    pub stack_limit: u32,
    /// Where machine code of functions is looked up and kept.
    pub cache: Option<&'a Cache>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            separate: &|_| false,
            host: &[],
            loop_limit: None,
            // Threads of rayon have 2 MiB, and functions of the program need some of that, too.
            stack_limit: 512 << 10,
            cache: None,
        }
    }
}

/// What compiling cost, and what came of it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Functions of machine code, the kernel itself among them.
    pub functions: usize,
    /// How many of them had to be compiled; the others were in the cache.
    pub compiled: usize,
    /// Bytes of machine code.
    pub code_bytes: usize,
    /// Bytes of stack that an invocation takes at most.
    pub stack_bytes: u32,
    /// Time for override constants and the representation between.
    pub lowering: Duration,
    /// Time for machine code.
    pub generation: Duration,
}

/// An entry point as machine code. Clones share it.
#[derive(Debug, Clone)]
pub struct Kernel {
    code: Arc<Code>,
    bindings: Arc<[Binding]>,
    workgroup_size: [u32; 3],
    /// Bytes of scratch memory that a workgroup needs: workgroup variables, and what waits at barriers.
    scratch_bytes: u32,
    statistics: Statistics,
}

impl Kernel {
    /// Compiles one entry point of a valid module. `constants` are values of its `override` constants by name; those
    /// that it doesn't declare are left out. Several functions are compiled at once by rayon.
    ///
    /// # Errors
    /// Where the text needs what is not supported (samplers, subgroups, ray queries, types other than `f32`, `i32`,
    /// `u32` and `bool`), or too much memory; with the place in the text.
    pub fn new(
        module: &naga::Module,
        info: &naga::valid::ModuleInfo,
        entry: &str,
        constants: &[(&str, f64)],
        options: &Options<'_>,
    ) -> Result<Self, CompileError> {
        let start = std::time::Instant::now();
        let (module, info) = lower::with_constants(module, info, entry, constants)?;
        let program = lower::lower(&module, &info, entry, options)?;
        let lowering = start.elapsed();
        let start = std::time::Instant::now();
        let (code, mut statistics) = generate::compile(&program, options)?;
        statistics.lowering = lowering;
        statistics.generation = start.elapsed();
        Ok(Self {
            code: Arc::new(code),
            bindings: program.bindings.into(),
            workgroup_size: program.workgroup_size,
            scratch_bytes: program.scratch_bytes,
            statistics,
        })
    }

    /// What has to be bound: the globals that the entry point uses and the functions that it calls, and no others.
    pub fn bindings(&self) -> &[Binding] {
        &self.bindings
    }

    /// Invocations of a workgroup along each axis.
    pub fn workgroup_size(&self) -> [u32; 3] {
        self.workgroup_size
    }

    /// What compiling it cost.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }
}
