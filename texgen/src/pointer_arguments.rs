//! Pointers to parts of variables as arguments: `add(&p.x)`, `add(&a[i])`.
//!
//! WGSL allows them; SPIR-V wants an argument to be a whole variable, and naga's writer panics on anything else. So the part is
//! passed as a copy: into a variable of the caller's before the call, and back behind it. WGSL lets no other argument of
//! the call reach what is written through a pointer, so nobody can tell the difference. This works on naga's form of
//! the module, where the index of an element is a value that was computed once, wherever the call stands.

use naga::{
    AddressSpace, Arena, Block, Expression, Function, Handle, LocalVariable, Module, Range, Span,
    Statement, Type, TypeInner,
};

/// Passes parts of variables as copies. Says whether there were any: the module is to be validated again then.
pub fn copy_pointer_arguments(module: &mut Module) -> bool {
    let pointee = |ty: Handle<Type>| match module.types[ty].inner {
        TypeInner::Pointer {
            base,
            space: AddressSpace::Function | AddressSpace::Private,
        } => Some(base),
        _ => None,
    };
    let parameters: Vec<Vec<Option<Handle<Type>>>> = module
        .functions
        .iter()
        .map(|(_, function)| function.arguments.iter().map(|a| pointee(a.ty)).collect())
        .collect();
    let mut changed = false;
    let entries = module.entry_points.iter_mut();
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    for function in functions.chain(entries.map(|entry| &mut entry.function)) {
        let mut caller = Caller {
            parameters: &parameters,
            expressions: &mut function.expressions,
            variables: &mut function.local_variables,
            changed: false,
        };
        caller.block(&mut function.body);
        changed |= caller.changed;
    }
    changed
}

/// The function whose calls are looked at.
struct Caller<'a> {
    /// Of each function and each of its parameters: what a pointer to a variable points to.
    parameters: &'a [Vec<Option<Handle<Type>>>],
    expressions: &'a mut Arena<Expression>,
    variables: &'a mut Arena<LocalVariable>,
    changed: bool,
}

impl Caller<'_> {
    fn block(&mut self, block: &mut Block) {
        let old = std::mem::take(block);
        for (mut statement, span) in old.span_into_iter() {
            match &mut statement {
                Statement::Block(inner) => self.block(inner),
                Statement::If { accept, reject, .. } => {
                    self.block(accept);
                    self.block(reject);
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        self.block(&mut case.body);
                    }
                }
                Statement::Loop {
                    body, continuing, ..
                } => {
                    self.block(body);
                    self.block(continuing);
                }
                Statement::Call {
                    function,
                    arguments,
                    ..
                } => {
                    let copies = self.copies(*function, arguments, span);
                    self.call(block, statement, &copies, span);
                    continue;
                }
                _ => {}
            }
            block.push(statement, span);
        }
    }

    /// Puts a variable in the place of each argument that points to a part of one. The pairs of part and variable.
    fn copies(
        &mut self,
        callee: Handle<Function>,
        arguments: &mut [Handle<Expression>],
        span: Span,
    ) -> Vec<[Handle<Expression>; 2]> {
        let parameters = self.parameters;
        let types = parameters
            .get(callee.index())
            .map_or(&[][..], Vec::as_slice);
        let mut copies = Vec::new();
        for (argument, ty) in arguments.iter_mut().zip(types) {
            let is_part = matches!(
                self.expressions[*argument],
                Expression::Access { .. } | Expression::AccessIndex { .. }
            );
            let Some(ty) = ty.filter(|_| is_part) else {
                continue;
            };
            let variable = LocalVariable {
                name: None,
                ty,
                init: None,
            };
            let variable = self.variables.append(variable, span);
            let copy = Expression::LocalVariable(variable);
            let copy = self.expressions.append(copy, span);
            copies.push([*argument, copy]);
            *argument = copy;
        }
        self.changed |= !copies.is_empty();
        copies
    }

    /// The call, with the copies made before it and given back behind it.
    fn call(
        &mut self,
        block: &mut Block,
        call: Statement,
        copies: &[[Handle<Expression>; 2]],
        span: Span,
    ) {
        for &[part, copy] in copies {
            self.assign(block, part, copy, span);
        }
        block.push(call, span);
        for &[part, copy] in copies {
            self.assign(block, copy, part, span);
        }
    }

    /// `*to = *from`.
    fn assign(
        &mut self,
        block: &mut Block,
        from: Handle<Expression>,
        to: Handle<Expression>,
        span: Span,
    ) {
        let load = Expression::Load { pointer: from };
        let value = self.expressions.append(load, span);
        block.push(Statement::Emit(Range::new_from_bounds(value, value)), span);
        let pointer = to;
        block.push(Statement::Store { pointer, value }, span);
    }
}
