//! Override constants become constants.
//!
//! naga's own way compacts the whole module, evaluates its expressions and checks it once more, which takes as long as
//! reading it did. What texts declare is nearly always a number of its own: that takes the place of the override, and all
//! else stays as it is, with what is known of it.

use std::borrow::Cow;

use naga::{
    ArraySize, Constant, Expression, Literal, Module, Override, Scalar, ShaderStage, TypeInner,
    valid::ModuleInfo,
};

use super::entry_index;
use crate::{CompileError, ErrorKind};

/// The module with its override constants replaced; there may be more in it than the entry point uses.
pub fn with_constants<'m>(
    module: &'m Module,
    info: &'m ModuleInfo,
    entry: &str,
    constants: &[(&str, f64)],
) -> Result<(Cow<'m, Module>, Cow<'m, ModuleInfo>), CompileError> {
    entry_index(module, entry)?;
    if module.overrides.is_empty() {
        return Ok((Cow::Borrowed(module), Cow::Borrowed(info)));
    }
    if let Some(replaced) = replaced(module, constants) {
        return Ok((Cow::Owned(replaced), Cow::Borrowed(info)));
    }
    let declared = |name: &str| {
        let mut overrides = module.overrides.iter();
        overrides.any(|(_, declared)| is_called(declared, name))
    };
    let constants = constants
        .iter()
        .filter(|(name, _)| declared(name))
        .map(|&(name, value)| (name.to_owned(), value))
        .collect();
    let stage = Some((ShaderStage::Compute, entry));
    naga::back::pipeline_constants::process_overrides(module, info, stage, &constants)
        .map_err(|error| ErrorKind::Constants(error.to_string()).into())
}

fn is_called(declared: &Override, name: &str) -> bool {
    match declared.id {
        Some(id) => name.parse() == Ok(id),
        None => declared.name.as_deref() == Some(name),
    }
}

/// None where an override, or what depends on it, is more than a number.
fn replaced(module: &Module, constants: &[(&str, f64)]) -> Option<Module> {
    let sizes = module.types.iter().any(|(_, ty)| {
        let size = match ty.inner {
            TypeInner::Array { size, .. } | TypeInner::BindingArray { size, .. } => size,
            _ => return false,
        };
        matches!(size, ArraySize::Pending(_))
    });
    let entries = &module.entry_points;
    let of_workgroups = entries
        .iter()
        .any(|entry| entry.workgroup_size_overrides.is_some());
    if sizes || of_workgroups {
        return None;
    }
    let is_plain = |expression: &Expression| {
        matches!(
            expression,
            Expression::Literal(_)
                | Expression::Constant(_)
                | Expression::ZeroValue(_)
                | Expression::Compose { .. }
                | Expression::Splat { .. }
                | Expression::Override(_)
        )
    };
    let mut globals = module.global_expressions.iter();
    if !globals.all(|(_, expression)| is_plain(expression)) {
        return None;
    }
    let mut new = module.clone();
    let mut handles = Vec::new();
    for (handle, declared) in module.overrides.iter() {
        let span = module.overrides.get_span(handle);
        let given = constants.iter().find(|(name, _)| is_called(declared, name));
        let init = match given {
            Some(&(_, value)) => {
                let TypeInner::Scalar(scalar) = module.types[declared.ty].inner else {
                    return None;
                };
                let literal = Expression::Literal(literal(scalar, value)?);
                new.global_expressions.append(literal, span)
            }
            None => declared.init?,
        };
        let constant = Constant {
            name: None,
            ty: declared.ty,
            init,
        };
        handles.push(new.constants.append(constant, span));
    }
    let replace = |expression: &mut Expression| {
        if let Expression::Override(handle) = *expression {
            *expression = Expression::Constant(handles[handle.index()]);
        }
    };
    let functions = new.functions.iter_mut().map(|(_, function)| function);
    let entries = new.entry_points.iter_mut().map(|entry| &mut entry.function);
    let own = functions
        .chain(entries)
        .map(|function| &mut function.expressions);
    for expressions in own.chain([&mut new.global_expressions]) {
        expressions
            .iter_mut()
            .for_each(|(_, expression)| replace(expression));
    }
    Some(new)
}

/// A value as WebIDL converts it; none where it doesn't fit.
fn literal(scalar: Scalar, value: f64) -> Option<Literal> {
    let fits = |least: f64, most: f64| value.trunc() >= least && value.trunc() <= most;
    match scalar {
        Scalar::BOOL => Some(Literal::Bool(value != 0.0 && !value.is_nan())),
        Scalar::I32 => {
            let fits = fits(f64::from(i32::MIN), f64::from(i32::MAX));
            fits.then_some(Literal::I32(value.trunc() as i32))
        }
        Scalar::U32 => {
            let fits = fits(0.0, f64::from(u32::MAX));
            fits.then_some(Literal::U32(value.trunc() as u32))
        }
        Scalar::F32 => {
            let narrow = value as f32;
            narrow.is_finite().then_some(Literal::F32(narrow))
        }
        _ => None,
    }
}
