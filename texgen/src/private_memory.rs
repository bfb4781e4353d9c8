//! How much memory per thread the variables of functions and of a whole kernel take, along the deepest chain of calls.
//!
//! naga's layout of the types is what counts. Drivers keep what they can in registers and merge what is not alive at
//! the same time, so this is what a texture asks for, not what a device gives it.

use std::collections::HashMap;

use naga::valid::FunctionInfo;
use naga::{AddressSpace, Block, EntryPoint, Function, Handle, Module, Statement, TypeInner};

pub(crate) fn bytes_of(module: &Module, function: &Function, is_entry: bool) -> u32 {
    let variables = function.local_variables.iter().map(|(_, local)| local.ty);
    let parameters = function
        .arguments
        .iter()
        .map(|argument| argument.ty)
        .filter(|ty| !(is_entry && matches!(module.types[*ty].inner, TypeInner::Array { .. })));
    variables
        .chain(parameters)
        .map(|ty| size_of(module, ty))
        .fold(0u32, u32::saturating_add)
}

pub(crate) fn size_of(module: &Module, ty: Handle<naga::Type>) -> u32 {
    let size = module.types[ty].inner.try_size(module.to_ctx());
    size.unwrap_or(0)
}

/// Bytes of private memory that a thread of a kernel asks for, by its types: the module's private variables that the entry
/// point uses (`uses` is naga's analysis of it), its own variables, and parameters and variables of the heaviest chain of
/// functions that it calls. Ray queries count nothing: their size is the driver's secret.
pub fn kernel_private_bytes(module: &Module, uses: &FunctionInfo, entry: &EntryPoint) -> u32 {
    let shared = module.global_variables.iter().filter(|(handle, global)| {
        global.space == AddressSpace::Private && !uses[*handle].is_empty()
    });
    let shared = shared.map(|(_, global)| size_of(module, global.ty));
    let own = entry.function.local_variables.iter();
    let own = own.map(|(_, local)| size_of(module, local.ty));
    let sizes = module.functions.iter();
    let sizes = sizes.map(|(handle, function)| (handle, bytes_of(module, function, false)));
    let chains = Chains::new(module, &sizes.collect());
    let below = chains.heaviest_below(&entry.function);
    let below = below.map_or(0, |callee| chains.0[&callee].0);
    shared.chain(own).fold(below, u32::saturating_add)
}

/// Of each function the bytes of the heaviest chain of calls that begins at it, and what it calls on that chain.
struct Chains(HashMap<Handle<Function>, (u32, Option<Handle<Function>>)>);

impl Chains {
    /// Of the functions with a size.
    fn new(module: &Module, sizes: &HashMap<Handle<Function>, u32>) -> Self {
        let mut chains = Self(HashMap::new());
        // naga has callees before their callers, so each function's best continuation is known when it is met.
        for (handle, function) in module.functions.iter() {
            let Some(&own) = sizes.get(&handle) else {
                continue;
            };
            let next = chains.heaviest_below(function);
            let below = next.map_or(0, |callee| chains.0[&callee].0);
            chains.0.insert(handle, (own.saturating_add(below), next));
        }
        chains
    }

    /// What a function calls that needs most.
    fn heaviest_below(&self, function: &Function) -> Option<Handle<Function>> {
        let mut called = Vec::new();
        calls(&function.body, &mut called);
        let known = called
            .into_iter()
            .filter_map(|callee| Some((self.0.get(&callee)?.0, callee)));
        let heaviest = known.max_by_key(|&(bytes, callee)| (bytes, std::cmp::Reverse(callee)));
        heaviest.map(|(_, callee)| callee)
    }
}

/// Bytes and names of the heaviest chain of calls that begins at `userProc`.
pub(crate) fn deepest(
    module: &Module,
    sizes: &HashMap<Handle<Function>, u32>,
) -> (u32, Vec<String>) {
    let chains = Chains::new(module, sizes);
    let mut at = module
        .functions
        .iter()
        .find(|(_, function)| function.name.as_deref() == Some("userProc"))
        .map(|(handle, _)| handle)
        .filter(|handle| chains.0.contains_key(handle));
    let bytes = at.map_or(0, |entry| chains.0[&entry].0);
    let mut names = Vec::new();
    while let Some(handle) = at {
        names.push(module.functions[handle].name.clone().unwrap_or_default());
        at = chains.0[&handle].1;
    }
    (bytes, names)
}

/// Functions that a block calls, in any of its branches.
fn calls(block: &Block, found: &mut Vec<Handle<Function>>) {
    for statement in block.iter() {
        match statement {
            Statement::Call { function, .. } => found.push(*function),
            Statement::Block(inner) => calls(inner, found),
            Statement::If { accept, reject, .. } => {
                calls(accept, found);
                calls(reject, found);
            }
            Statement::Switch { cases, .. } => {
                for case in cases {
                    calls(&case.body, found);
                }
            }
            Statement::Loop {
                body, continuing, ..
            } => {
                calls(body, found);
                calls(continuing, found);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kernel_asks_for_private_variables_and_its_heaviest_chain() {
        let text = "
            var<private> site: array<vec4f, 3>;
            var<private> unused: array<vec4f, 100>;
            var<workgroup> shared_by_all: array<vec4f, 16>;
            @group(0) @binding(0) var<storage, read_write> data: array<f32>;
            fn leaf(x: f32) -> f32 { var table: array<f32, 5>; table[u32(x)] = x; return table[0] + site[0].x; }
            fn branch(p: ptr<function, vec4f>) -> f32 { (*p).x += leaf(1.0); return (*p).x; }
            fn never(m: mat4x4f) -> f32 { return m[0].x + unused[1].x; }
            @compute @workgroup_size(1)
            fn other() { data[0] = never(mat4x4f()); }
            @compute @workgroup_size(1)
            fn main(@builtin(global_invocation_id) id: vec3u) {
                var v = vec4f(f32(id.x));
                shared_by_all[0] = v;
                for (var i = 0u; i < 2u; i++) { data[i] = branch(&v) + leaf(2.0); }
            }";
        let module = naga::front::wgsl::parse_str(text).expect("valid");
        let info = naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::empty(),
        )
        .validate(&module)
        .expect("valid");
        let bytes = |name: &str| {
            let at = module.entry_points.iter().position(|e| e.name == name);
            let at = at.expect("it is there");
            kernel_private_bytes(&module, info.get_entry_point(at), &module.entry_points[at])
        };
        // The site; `v` and `i`; a pointer; a number and a table of five.
        assert_eq!(bytes("main"), 48 + 16 + 4 + 4 + 4 + 20);
        assert_eq!(bytes("other"), 1600 + 64);
    }
}
