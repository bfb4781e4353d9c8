//! WGSL to machine code.
//!
//! `naga::Module` → ([`kernel_ir`]) → linear code over scalars → (`generate`) → machine code by Cranelift.
//!
//! **Safety.** A kernel touches nothing but its stack, the dispatch's scratch memory, and the resources that were bound:
//! every index is restricted to its array as WebGPU's implementations do it, and [`Kernel::bind`] refuses a resource
//! that is smaller than what the text declares. Machine code lies in memory that is writable or executable, never both
//! (`cranelift-jit` writes it to fresh pages, which then become executable and read-only), and what a chain of
//! functions takes of the stack is summed up and limited when they are compiled; none of them can call itself.

mod ahead;
mod bind;
mod cache;
mod dispatch;
#[cfg_attr(
    target_family = "wasm",
    expect(dead_code, reason = "nothing is linked")
)]
mod generate;
pub mod runtime;

pub use ahead::{Ahead, AheadFunction};
pub use bind::{BindError, Resource};
pub use cache::Cache;
pub use dispatch::{BoundKernel, EntryPoint};
use kernel_ir::ir;
pub use kernel_ir::{Access, Binding, BindingKind, CompileError, ErrorKind, Format, ImageHeader};

use std::{
    sync::{Arc, OnceLock},
    time::Duration,
};

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
    /// Kernels that were compiled before: one that computes the same is taken instead of compiling.
    pub ahead: &'static [Ahead],
    /// Functions that were compiled before: called in place of functions of the text that compute the same. Only what
    /// [`Self::separate`] names is called at all.
    pub ahead_functions: &'static [AheadFunction],
    /// Functions that were compiled before for eight invocations at once, see [`Kernel::add_lanes`].
    pub ahead_lanes: &'static [AheadFunction],
    /// Override constants that only leave out what isn't needed: what was compiled before with all of them set will do.
    pub omissions: &'static [&'static str],
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
            ahead: &[],
            ahead_functions: &[],
            ahead_lanes: &[],
            omissions: &[],
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
    /// Functions that were compiled with the program and are called instead.
    pub ahead: usize,
    /// Bytes of machine code.
    pub code_bytes: usize,
    /// Bytes of stack that an invocation takes at most.
    pub stack_bytes: u32,
    /// Time for override constants and the representation between.
    pub lowering: Duration,
    /// Time for machine code.
    pub generation: Duration,
}

/// The constants with these set.
fn with_all<'a>(constants: &[(&'a str, f64)], set: &[&'static str]) -> Vec<(&'a str, f64)> {
    (constants.iter())
        .map(|&(name, value)| (name, if set.contains(&name) { 1.0 } else { value }))
        .collect()
}

/// Whether code in lanes is worth it, and may use what it wants.
fn has_vectors() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    return false;
}

/// Where machine code came from.
#[derive(Debug, Clone)]
enum Machine {
    Compiled(Arc<Code>),
    Ahead(EntryPoint),
}

impl Machine {
    fn entry(&self) -> EntryPoint {
        match self {
            Self::Compiled(code) => code.entry(),
            Self::Ahead(entry) => *entry,
        }
    }
}

/// An entry point as machine code. Clones share it.
#[derive(Debug, Clone)]
pub struct Kernel {
    code: Machine,
    /// Code for eight invocations at once, once there is some.
    lanes: Arc<OnceLock<Code>>,
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
        let lowered = |constants: &[(&str, f64)]| {
            let (module, info) = kernel_ir::with_constants(module, info, entry, constants)?;
            let options = kernel_ir::Options {
                separate: options.separate,
                host: options.host,
                loop_limit: options.loop_limit,
            };
            kernel_ir::lower(&module, &info, entry, &options)
        };
        let mut program = lowered(constants)?;
        let mut found = ahead::find(&program, options.ahead);
        if found.is_none() && !options.omissions.is_empty() && !options.ahead.is_empty() {
            let all = lowered(&with_all(constants, options.omissions))?;
            found = ahead::find(&all, options.ahead);
            if found.is_some() {
                program = all;
            }
        }
        let lowering = start.elapsed();
        let start = std::time::Instant::now();
        let (code, mut statistics) = match found {
            Some(entry) => (Machine::Ahead(entry), Statistics::default()),
            None => {
                let (code, statistics) = generate::compile(&program, options)?;
                (Machine::Compiled(Arc::new(code)), statistics)
            }
        };
        statistics.lowering = lowering;
        statistics.generation = start.elapsed();
        Ok(Self {
            code,
            lanes: Arc::default(),
            bindings: program.bindings.into(),
            workgroup_size: program.workgroup_size,
            scratch_bytes: program.scratch_bytes,
            statistics,
        })
    }

    /// Compiles it once more, so that eight invocations run at once: from then on it is that code that runs, with the same
    /// results. Arguments and options are those of [`Self::new`]; functions that `once` names are called once for each set of
    /// different scalars that invocations have for them.
    ///
    /// It takes longer to compile than the other code; so a kernel may begin without it.
    ///
    /// # Errors
    /// Where it can't be done; then nothing changes.
    pub fn add_lanes(
        &self,
        module: &naga::Module,
        info: &naga::valid::ModuleInfo,
        entry: &str,
        constants: &[(&str, f64)],
        options: &Options<'_>,
        once: &(dyn Fn(&str) -> bool + Sync),
    ) -> Result<(), CompileError> {
        if self.is_ahead() {
            return Err(ErrorKind::unsupported("more code than what came compiled"));
        }
        if !has_vectors() {
            return Err(ErrorKind::unsupported("vectors of this processor"));
        }
        if self.is_in_lanes() {
            return Ok(());
        }
        let lowered = || {
            let (module, info) = kernel_ir::with_constants(module, info, entry, constants)?;
            let separate = |name: &str| once(name) || (options.separate)(name);
            let options = kernel_ir::Options {
                separate: &separate,
                host: options.host,
                loop_limit: options.loop_limit,
            };
            kernel_ir::lower(&module, &info, entry, &options)
        };
        let program = lowered()?;
        let code = generate::compile_lanes(&program, options, once)?;
        // It is to be bound as the other code is.
        if *program.bindings != *self.bindings || program.scratch_bytes != self.scratch_bytes {
            return Err(ErrorKind::unsupported("other bindings in lanes"));
        }
        let _ = self.lanes.set(code);
        Ok(())
    }

    /// Whether somebody else has a share of it.
    pub(in crate::native) fn is_shared(&self) -> bool {
        Arc::strong_count(&self.lanes) > 1
    }

    /// Whether it runs eight invocations at once, see [`Self::add_lanes`].
    pub fn is_in_lanes(&self) -> bool {
        self.lanes.get().is_some()
    }

    fn entry(&self) -> EntryPoint {
        (self.lanes.get()).map_or_else(|| self.code.entry(), Code::entry)
    }

    /// What has to be bound: the globals that the entry point uses and the functions that it calls, and no others.
    pub fn bindings(&self) -> &[Binding] {
        &self.bindings
    }

    /// Invocations of a workgroup along each axis.
    pub fn workgroup_size(&self) -> [u32; 3] {
        self.workgroup_size
    }

    /// Whether it was compiled before, see [`Options::ahead`].
    pub fn is_ahead(&self) -> bool {
        matches!(self.code, Machine::Ahead(_))
    }

    /// What compiling it cost.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }
}
