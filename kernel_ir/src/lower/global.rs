//! Where global variables lie.

use naga::{
    AddressSpace, ArraySize, Expression, Function, GlobalVariable, Handle, ImageClass,
    ImageDimension, Literal, ScalarKind, StorageAccess, TypeInner, valid::FunctionInfo,
};

use super::{
    Lowering,
    emit::{Address, Operand, boolean, float, int},
    place::Place,
    types::components,
};
use crate::{
    Access, Binding, BindingKind, CompileError, ErrorKind,
    ir::{Memory, Type, Variable, context},
};

/// Where a global lies.
#[derive(Debug, Clone, Copy)]
pub(super) enum GlobalPlace {
    /// A buffer: its number among the bindings.
    Buffer { binding: usize, memory: Memory },
    /// An image.
    Image { binding: usize },
    /// Bytes into the memory of private variables.
    Private { offset: u32 },
    /// Variables of the entry point, from this one on.
    Variables { first: Variable },
    /// Bytes into the scratch memory.
    Workgroup { offset: u32 },
}

impl Lowering<'_> {
    /// Lists the bindings, and lays out private and workgroup variables.
    pub(super) fn place_globals(&mut self, info: &FunctionInfo) -> Result<(), CompileError> {
        let module = self.module;
        for (handle, variable) in module.global_variables.iter() {
            if info[handle].is_empty() {
                continue;
            }
            let place = match variable.space {
                AddressSpace::Private => {
                    if !self.plan.globals_in_memory.contains(&handle) {
                        // The entry point makes the variables.
                        continue;
                    }
                    let offset = add_aligned(&mut self.private_bytes, self.types.size(variable.ty));
                    GlobalPlace::Private { offset }
                }
                AddressSpace::WorkGroup => {
                    let size = self.types.size(variable.ty);
                    let offset = add_aligned(&mut self.workgroup_bytes, size);
                    GlobalPlace::Workgroup { offset }
                }
                AddressSpace::Uniform | AddressSpace::Storage { .. } | AddressSpace::Handle => {
                    let span = module.global_variables.get_span(handle);
                    self.bind(variable).map_err(|e| e.at(span))?
                }
                other => {
                    let span = module.global_variables.get_span(handle);
                    let what = format!("variables in {other:?}");
                    return Err(ErrorKind::unsupported(what).at(span));
                }
            };
            self.globals.insert(handle, place);
        }
        Ok(())
    }

    fn bind(&mut self, variable: &GlobalVariable) -> Result<GlobalPlace, CompileError> {
        let number = self.bindings.len();
        let inner = &self.module.types[variable.ty].inner;
        let (kind, place) = if variable.space == AddressSpace::Handle {
            let binding = number;
            (image_kind(inner)?, GlobalPlace::Image { binding })
        } else {
            let writable = matches!(variable.space, AddressSpace::Storage { access }
                if access.contains(StorageAccess::STORE));
            let (access, memory) = match writable {
                true => (Access::Write, Memory::Plain),
                false => (Access::Read, Memory::Constant),
            };
            let size = self.types.size(variable.ty);
            let least_bytes = u32::try_from(size)
                .ok()
                .filter(|&bytes| i32::try_from(bytes).is_ok())
                .ok_or_else(|| ErrorKind::unsupported("a buffer type of 2 GiB or more"))?;
            let kind = BindingKind::Buffer {
                access,
                least_bytes,
                array: self.runtime_array(inner),
            };
            let binding = number;
            (kind, GlobalPlace::Buffer { binding, memory })
        };
        let declared = variable.binding.as_ref();
        self.bindings.push(Binding {
            name: variable.name.clone().unwrap_or_default(),
            group: declared.map_or(0, |declared| declared.group),
            binding: declared.map_or(0, |declared| declared.binding),
            kind,
        });
        Ok(place)
    }

    /// The number among the bindings of what is called in a function's place.
    pub(super) fn host_binding(&mut self, function: Handle<Function>, words: [usize; 2]) -> usize {
        let name = self.module.functions[function].name.as_deref();
        let name = name.unwrap_or_default();
        let kind = BindingKind::Function { words };
        let mut known = self.bindings.iter();
        let known = known.position(|known| known.kind == kind && known.name == name);
        known.unwrap_or_else(|| {
            self.bindings.push(Binding {
                name: name.to_owned(),
                group: 0,
                binding: 0,
                kind,
            });
            self.bindings.len() - 1
        })
    }

    /// Where a runtime-sized array starts in a type, and bytes from element to element.
    fn runtime_array(&self, inner: &TypeInner) -> Option<(u32, u32)> {
        match *inner {
            TypeInner::Array {
                size: ArraySize::Dynamic,
                stride,
                ..
            } => Some((0, stride)),
            TypeInner::Struct { ref members, .. } => {
                let last = members.last()?;
                let (_, stride) = self.runtime_array(&self.module.types[last.ty].inner)?;
                Some((last.offset, stride))
            }
            _ => None,
        }
    }

    /// The place of a global, for the function that is being written.
    pub(super) fn global(&mut self, handle: Handle<GlobalVariable>) -> Result<Place, CompileError> {
        let place = *self
            .globals
            .get(&handle)
            .ok_or_else(|| ErrorKind::unsupported("a global variable outside of its kernel"))?;
        Ok(match place {
            GlobalPlace::Variables { first } => Place::Variables(first),
            GlobalPlace::Image { binding } => Place::Image(binding),
            GlobalPlace::Private { offset } => Place::Memory(Address {
                base: self.private,
                offset: offset as i32,
                memory: Memory::Plain,
                binding: None,
            }),
            GlobalPlace::Workgroup { offset } => Place::Memory(Address {
                base: self
                    .scratch
                    .ok_or_else(|| ErrorKind::unsupported("workgroup memory here"))?,
                offset: offset as i32,
                memory: Memory::Plain,
                binding: None,
            }),
            GlobalPlace::Buffer { binding, memory } => {
                let entry = self.context_place(context::binding(binding));
                let Operand::Value(base) = self.code.load(entry, Type::Pointer) else {
                    unreachable!("a load gives a value");
                };
                Place::Memory(Address {
                    base,
                    offset: 0,
                    memory,
                    binding: Some(binding),
                })
            }
        })
    }

    /// Bytes into the dispatch's context.
    pub(super) fn context_place(&self, offset: u32) -> Address {
        Address {
            base: self.context,
            offset: offset as i32,
            memory: Memory::Constant,
            binding: None,
        }
    }

    /// The scalars of a constant.
    pub(super) fn constant(
        &mut self,
        handle: Handle<Expression>,
    ) -> Result<Vec<Operand>, CompileError> {
        let module = self.module;
        let span = module.global_expressions.get_span(handle);
        Ok(match module.global_expressions[handle] {
            Expression::Literal(ref value) => vec![literal(value).map_err(|e| e.at(span))?],
            Expression::Constant(constant) => self.constant(module.constants[constant].init)?,
            Expression::ZeroValue(ty) => self.zeros(ty)?,
            Expression::Compose { ref components, .. } => {
                let mut all = Vec::new();
                for &component in components {
                    all.extend(self.constant(component)?);
                }
                all
            }
            Expression::Splat { size, value } => {
                let value = self.constant(value)?;
                value.repeat(components(size) as usize)
            }
            ref other => {
                let what = format!("{other:?} in a constant");
                return Err(ErrorKind::unsupported(what).at(span));
            }
        })
    }

    /// Zero of a type.
    pub(super) fn zeros(&mut self, ty: Handle<naga::Type>) -> Result<Vec<Operand>, CompileError> {
        let parts = self.types.parts(ty)?;
        Ok(parts
            .iter()
            .map(|part| Operand::Constant(part.ty, 0))
            .collect())
    }
}

/// A number of the text.
pub(super) fn literal(literal: &Literal) -> Result<Operand, CompileError> {
    Ok(match *literal {
        Literal::F32(x) => float(x),
        Literal::U32(x) => int(x),
        Literal::I32(x) => int(x as u32),
        Literal::Bool(x) => boolean(x),
        ref other => return Err(ErrorKind::unsupported(format!("the number {other:?}"))),
    })
}

/// Reserves `size` bytes: where they start.
fn add_aligned(bytes: &mut u64, size: u64) -> u32 {
    // Too much is an error when all of it is summed up.
    let offset = u32::try_from(*bytes).unwrap_or(0);
    *bytes = (*bytes + size).next_multiple_of(16);
    offset
}

fn image_kind(inner: &TypeInner) -> Result<BindingKind, CompileError> {
    let TypeInner::Image {
        dim: ImageDimension::D2,
        arrayed,
        class,
    } = *inner
    else {
        let what = match inner {
            TypeInner::Sampler { .. } => "a sampler".to_owned(),
            TypeInner::AccelerationStructure { .. } => "an acceleration structure".to_owned(),
            TypeInner::Image { dim, .. } => format!("a texture of dimension {dim:?}"),
            other => format!("a binding of type {other:?}"),
        };
        return Err(ErrorKind::unsupported(what));
    };
    let (access, scalar) = match class {
        ImageClass::Sampled { kind, multi: false } => (Access::Read, kind),
        ImageClass::Storage { format, access } => {
            let access = match access.contains(StorageAccess::STORE) {
                true => Access::Write,
                false => Access::Read,
            };
            (access, naga::Scalar::from(format).kind)
        }
        other => {
            return Err(ErrorKind::unsupported(format!(
                "a texture of class {other:?}"
            )));
        }
    };
    if scalar == ScalarKind::Sint {
        return Err(ErrorKind::unsupported("a texture of signed integers"));
    }
    Ok(BindingKind::Image {
        access,
        arrayed,
        scalar,
    })
}
