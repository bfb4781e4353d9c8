//! Composites as lists of scalars.

use std::{collections::HashMap, sync::Arc};

use naga::{ArraySize, Handle, Module, Scalar, ScalarKind, TypeInner, VectorSize};

use crate::{CompileError, ErrorKind, ir::Type};

/// The most scalars of a value; each takes instructions of its own wherever it is copied.
pub(super) const MOST_PARTS: u32 = 4096;

/// A scalar of a composite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Part {
    /// Bytes from the composite's start, as WGSL lays it out.
    pub(super) offset: u32,
    pub(super) ty: Type,
}

/// Parts of a module's types.
pub(super) struct Types<'m> {
    module: &'m Module,
    parts: HashMap<Handle<naga::Type>, Arc<[Part]>>,
}

/// Scalars of a vector.
pub(super) fn components(size: VectorSize) -> u32 {
    size as u32
}

/// Bytes from column to column of a matrix of floats.
pub(super) fn column_stride(rows: VectorSize) -> u32 {
    match rows {
        VectorSize::Bi => 8,
        VectorSize::Tri | VectorSize::Quad => 16,
    }
}

/// The scalar as code sees it.
pub(super) fn scalar_type(scalar: Scalar) -> Result<Type, CompileError> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => Ok(Type::F32),
        (ScalarKind::Sint | ScalarKind::Uint, 4) => Ok(Type::I32),
        (ScalarKind::Bool, _) => Ok(Type::Bool),
        (kind, width) => {
            let bits = u32::from(width) * 8;
            let name = match kind {
                ScalarKind::Float => "f",
                ScalarKind::Sint => "i",
                ScalarKind::Uint => "u",
                ScalarKind::Bool | ScalarKind::AbstractInt | ScalarKind::AbstractFloat => "?",
            };
            Err(ErrorKind::unsupported(format!("the type `{name}{bits}`")))
        }
    }
}

fn spread(count: u32, stride: u32, of: &[Part]) -> impl Iterator<Item = Part> {
    (0..count).flat_map(move |index| {
        of.iter().map(move |part| Part {
            offset: part.offset + index * stride,
            ty: part.ty,
        })
    })
}

impl<'m> Types<'m> {
    pub(super) fn new(module: &'m Module) -> Self {
        Self {
            module,
            parts: HashMap::new(),
        }
    }

    /// The scalars of a type, in order.
    pub(super) fn parts(&mut self, ty: Handle<naga::Type>) -> Result<Arc<[Part]>, CompileError> {
        if let Some(known) = self.parts.get(&ty) {
            return Ok(known.clone());
        }
        let module = self.module;
        let span = module.types.get_span(ty);
        let parts: Arc<[Part]> = self
            .of_inner(&module.types[ty].inner)
            .map_err(|e| e.at(span))?
            .into();
        self.parts.insert(ty, parts.clone());
        Ok(parts)
    }

    /// How many scalars a type has; none for what has no size.
    pub(super) fn count(&self, inner: &TypeInner) -> u64 {
        let of = |ty: Handle<naga::Type>| self.count(&self.module.types[ty].inner);
        match *inner {
            TypeInner::Scalar(_) | TypeInner::Atomic(_) => 1,
            TypeInner::Vector { size, .. } => u64::from(components(size)),
            TypeInner::Matrix { columns, rows, .. } => {
                u64::from(components(columns) * components(rows))
            }
            TypeInner::Array {
                base,
                size: ArraySize::Constant(length),
                ..
            } => of(base).saturating_mul(u64::from(length.get())),
            TypeInner::Struct { ref members, .. } => members
                .iter()
                .fold(0, |sum: u64, member| sum.saturating_add(of(member.ty))),
            _ => 0,
        }
    }

    /// The scalars of a type that may have no name.
    pub(super) fn of_inner(&mut self, inner: &TypeInner) -> Result<Vec<Part>, CompileError> {
        let scalars = self.count(inner);
        if scalars > u64::from(MOST_PARTS) {
            let most = MOST_PARTS;
            return Err(ErrorKind::TooLarge { scalars, most }.into());
        }
        let part = |scalar| scalar_type(scalar).map(|ty| Part { offset: 0, ty });
        Ok(match *inner {
            TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => vec![part(scalar)?],
            TypeInner::Vector { size, scalar } => {
                spread(components(size), 4, &[part(scalar)?]).collect()
            }
            TypeInner::Matrix {
                columns,
                rows,
                scalar,
            } => {
                let column: Vec<_> = spread(components(rows), 4, &[part(scalar)?]).collect();
                spread(components(columns), column_stride(rows), &column).collect()
            }
            TypeInner::Array {
                base,
                size: ArraySize::Constant(length),
                stride,
            } => {
                let element = self.parts(base)?;
                let stride = self.stride(base, stride);
                spread(length.get(), stride, &element).collect()
            }
            TypeInner::Struct { ref members, .. } => {
                let mut parts = Vec::new();
                for (index, member) in members.iter().enumerate() {
                    let offset = self.offset(members, index);
                    let of_member = self.parts(member.ty)?;
                    parts.extend(of_member.iter().map(|part| Part {
                        offset: part.offset + offset,
                        ty: part.ty,
                    }));
                }
                parts
            }
            ref other => {
                return Err(ErrorKind::unsupported(format!("a value of type {other:?}")));
            }
        })
    }

    /// Whether there are truth values in a type. WGSL says nothing of how they lie in memory: no buffer holds any. Here each
    /// takes a word, and what contains them is packed: naga's own sizes are too small.
    fn has_bools(&self, inner: &TypeInner) -> bool {
        let of = |ty: Handle<naga::Type>| self.has_bools(&self.module.types[ty].inner);
        match *inner {
            TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } => {
                scalar.kind == ScalarKind::Bool
            }
            TypeInner::Array { base, .. } => of(base),
            TypeInner::Struct { ref members, .. } => members.iter().any(|member| of(member.ty)),
            _ => false,
        }
    }

    /// Bytes in memory.
    pub(super) fn size(&self, ty: Handle<naga::Type>) -> u64 {
        let inner = &self.module.types[ty].inner;
        if !self.has_bools(inner) {
            return u64::from(inner.size(self.module.to_ctx()));
        }
        match *inner {
            TypeInner::Array {
                base,
                size: ArraySize::Constant(length),
                ..
            } => self.size(base).saturating_mul(u64::from(length.get())),
            TypeInner::Struct { ref members, .. } => members.iter().fold(0, |sum: u64, member| {
                sum.saturating_add(self.size(member.ty))
            }),
            _ => 4 * self.count(inner),
        }
    }

    /// Bytes from element to element of an array, of which naga says `stride`.
    pub(super) fn stride(&self, base: Handle<naga::Type>, stride: u32) -> u32 {
        match self.has_bools(&self.module.types[base].inner) {
            true => u32::try_from(self.size(base)).unwrap_or(u32::MAX),
            false => stride,
        }
    }

    /// Bytes before a member of a struct.
    pub(super) fn offset(&self, members: &[naga::StructMember], index: usize) -> u32 {
        let of = |ty: Handle<naga::Type>| self.has_bools(&self.module.types[ty].inner);
        if !members.iter().any(|member| of(member.ty)) {
            return members[index].offset;
        }
        let before = members[..index].iter().map(|member| self.size(member.ty));
        u32::try_from(before.fold(0, u64::saturating_add)).unwrap_or(u32::MAX)
    }
}
