//! Puts machine code where it can run.

use cranelift_codegen::{ir, isa::OwnedTargetIsa};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{
    FuncId, Linkage, Module, ModuleReloc, ModuleRelocTarget, default_libcall_names,
};

use super::{Part, Target, refused};
use crate::native::compile::{CompileError, dispatch::EntryPoint, ir::Program, runtime};

/// A kernel in executable memory, which is freed with it.
pub(in super::super) struct Code {
    entry: EntryPoint,
    /// None only while it is dropped.
    module: Option<JITModule>,
    /// Constants that the code points to.
    _parts: Vec<Part>,
}

// SAFETY: once linked, a module is only kept, and then dropped: its code and what that points to never change.
unsafe impl Send for Code {}
// SAFETY: as above.
unsafe impl Sync for Code {}

impl Code {
    /// The entry point, as long as `self` lives.
    pub(in super::super) fn entry(&self) -> EntryPoint {
        self.entry
    }
}

impl std::fmt::Debug for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Code").finish_non_exhaustive()
    }
}

impl Drop for Code {
    fn drop(&mut self) {
        if let Some(module) = self.module.take() {
            // SAFETY: whoever runs the code holds a share of `self`, so nobody does.
            unsafe { module.free_memory() };
        }
    }
}

/// Links functions that fit the program's, one by one.
pub(super) fn link(
    program: &Program,
    parts: Vec<Part>,
    isa: OwnedTargetIsa,
) -> Result<Code, CompileError> {
    let failed = |error: cranelift_module::ModuleError| refused("the kernel", error);
    let convention = isa.default_call_conv();
    let mut builder = JITBuilder::with_isa(isa, default_libcall_names());
    builder.symbols(runtime::library());
    for (index, part) in parts.iter().enumerate() {
        if let Part::Ahead(function) = part {
            builder.symbol(format!("f{index}"), function.address());
        }
    }
    let mut module = JITModule::new(builder);
    // Its signature matters to nobody: addresses are all that is put in place.
    let signature = ir::Signature::new(convention);
    let ids = (parts.iter().enumerate())
        .map(|(index, part)| {
            let linkage = match part {
                Part::Compiled(_) => Linkage::Local,
                Part::Ahead(_) | Part::Unused => Linkage::Import,
            };
            module
                .declare_function(&format!("f{index}"), linkage, &signature)
                .map_err(failed)
        })
        .collect::<Result<Vec<FuncId>, CompileError>>()?;
    for ((part, function), &id) in parts.iter().zip(&program.functions).zip(&ids) {
        let Part::Compiled(code) = part else {
            continue;
        };
        let places: Vec<ModuleReloc> = code
            .places
            .iter()
            .map(|place| ModuleReloc {
                offset: place.offset,
                kind: place.kind,
                name: match place.target {
                    Target::Callee(callee) => ids[function.callees[callee as usize]].into(),
                    Target::Library(call) => ModuleRelocTarget::LibCall(call),
                    Target::Own(offset) => ModuleRelocTarget::FunctionOffset(id, offset),
                },
                addend: place.addend,
            })
            .collect();
        module
            .define_function_bytes(id, code.alignment, &code.bytes, &places)
            .map_err(failed)?;
    }
    module.finalize_definitions().map_err(failed)?;
    let entry = module.get_finalized_function(ids[0]);
    Ok(Code {
        // SAFETY: the first function is the entry point, written with these parameters.
        entry: unsafe { std::mem::transmute::<*const u8, EntryPoint>(entry) },
        module: Some(module),
        _parts: parts,
    })
}
