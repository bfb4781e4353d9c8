//! Members, columns, components and elements. An index that is computed is restricted to what there is.

use naga::{ArraySize, Expression, Handle, TypeInner};

use super::{
    Lowering,
    emit::{Address, Operand, int},
    function::Frame,
    place::{Evaluated, Place},
    types::{Part, column_stride, components},
};
use crate::{
    CompileError, ErrorKind,
    ir::{Binary, Comparison, Memory, Variable},
};

/// What a composite is made of.
struct Elements {
    /// None for runtime-sized arrays.
    count: Option<u32>,
    /// Bytes from one to the next.
    stride: u32,
    /// Scalars of each.
    scalars: usize,
}

impl<'m> Lowering<'m> {
    fn elements(&mut self, inner: &TypeInner) -> Result<Elements, CompileError> {
        Ok(match *inner {
            TypeInner::Vector { size, .. }
            | TypeInner::ValuePointer {
                size: Some(size), ..
            } => Elements {
                count: Some(components(size)),
                stride: 4,
                scalars: 1,
            },
            TypeInner::Matrix { columns, rows, .. } => Elements {
                count: Some(components(columns)),
                stride: column_stride(rows),
                scalars: components(rows) as usize,
            },
            TypeInner::Array { base, size, stride } => Elements {
                count: match size {
                    ArraySize::Constant(count) => Some(count.get()),
                    ArraySize::Dynamic => None,
                    ArraySize::Pending(_) => {
                        return Err(ErrorKind::unsupported("an array of unknown size"));
                    }
                },
                stride: self.types.stride(base, stride),
                scalars: self.types.count(&self.module.types[base].inner) as usize,
            },
            ref other => return Err(ErrorKind::unsupported(format!("an index into {other:?}"))),
        })
    }

    /// Where a member or element lies: scalars before it, bytes before it, scalars of it.
    fn step(&mut self, inner: &TypeInner, index: u32) -> Result<(usize, u32, usize), CompileError> {
        if let TypeInner::Struct { ref members, .. } = *inner {
            let count = |member: &naga::StructMember| {
                self.types.count(&self.module.types[member.ty].inner) as usize
            };
            let before = members[..index as usize].iter().map(count).sum();
            let member = &members[index as usize];
            let offset = self.types.offset(members, index as usize);
            return Ok((before, offset, count(member)));
        }
        let of = self.elements(inner)?;
        Ok((
            (index as usize).saturating_mul(of.scalars),
            index.wrapping_mul(of.stride),
            of.scalars,
        ))
    }

    pub(super) fn access_index(
        &mut self,
        frame: &mut Frame<'m>,
        base: Handle<Expression>,
        index: u32,
    ) -> Result<Evaluated, CompileError> {
        let module = self.module;
        let evaluated = self.evaluate(frame, base)?;
        let inner = match *self.inner(frame, base) {
            TypeInner::Pointer { base, .. } => &module.types[base].inner,
            ref other => other,
        };
        // A runtime-sized array may be shorter than a constant index says.
        if let TypeInner::Array {
            size: ArraySize::Dynamic,
            ..
        } = *inner
            && let Evaluated::Place(place) = evaluated
        {
            let place = self.restricted(place, inner, int(index))?;
            return Ok(Evaluated::Place(place));
        }
        let in_struct = matches!(inner, TypeInner::Struct { .. });
        let inner = inner.clone();
        let (before, bytes, scalars) = self.step(&inner, index)?;
        Ok(match evaluated {
            Evaluated::Scalars(all) => Evaluated::Scalars(all[before..before + scalars].to_vec()),
            Evaluated::Place(Place::Variables(first)) => {
                Evaluated::Place(Place::Variables(Variable(first.0 + before as u32)))
            }
            Evaluated::Place(Place::Memory(address)) => {
                let binding = address.binding.filter(|_| in_struct);
                Evaluated::Place(Place::Memory(Address {
                    binding,
                    ..address.plus(bytes)
                }))
            }
            Evaluated::Place(Place::Image(_)) => {
                return Err(ErrorKind::unsupported("an index into a texture"));
            }
        })
    }

    pub(super) fn access(
        &mut self,
        frame: &mut Frame<'m>,
        base: Handle<Expression>,
        index: Handle<Expression>,
    ) -> Result<Evaluated, CompileError> {
        let module = self.module;
        let index = self.scalar(frame, index)?;
        let inner = match *self.inner(frame, base) {
            TypeInner::Pointer { base, .. } => module.types[base].inner.clone(),
            ref other => other.clone(),
        };
        match self.evaluate(frame, base)? {
            Evaluated::Scalars(all) => {
                Ok(Evaluated::Scalars(self.element_of(&inner, &all, index)?))
            }
            Evaluated::Place(place) => Ok(Evaluated::Place(self.restricted(place, &inner, index)?)),
        }
    }

    /// The place of an element.
    fn restricted(
        &mut self,
        place: Place,
        inner: &TypeInner,
        index: Operand,
    ) -> Result<Place, CompileError> {
        let of = self.elements(inner)?;
        let address = match (place, index) {
            (Place::Memory(address), _) => address,
            (Place::Variables(first), Operand::Constant(_, index)) => {
                let index = index.min(of.count.unwrap_or(1) - 1);
                return Ok(Place::Variables(Variable(
                    first.0 + index * of.scalars as u32,
                )));
            }
            _ => return Err(ErrorKind::unsupported("an index into this variable")),
        };
        let last = match (of.count, address.binding) {
            (Some(count), _) => int(count - 1),
            (None, Some(binding)) => self.last_index(binding),
            (None, None) => return Err(ErrorKind::unsupported("an array without a length")),
        };
        let index = match (index, last) {
            (Operand::Constant(_, 0), _) => index,
            _ => self.code.binary(Binary::UnsignedMin, index, last),
        };
        Ok(Place::Memory(self.code.element(address, index, of.stride)))
    }

    /// An element of a value.
    fn element_of(
        &mut self,
        inner: &TypeInner,
        all: &[Operand],
        index: Operand,
    ) -> Result<Vec<Operand>, CompileError> {
        let of = self.elements(inner)?;
        let count = of.count.unwrap_or(1);
        let element = |index: u32| {
            let first = index as usize * of.scalars;
            &all[first..first + of.scalars]
        };
        if let Operand::Constant(_, index) = index {
            return Ok(element(index.min(count - 1)).to_vec());
        }
        if count <= 4 && of.scalars <= 4 {
            let mut chosen = element(count - 1).to_vec();
            for candidate in (0..count - 1).rev() {
                let is = self.code.compare(Comparison::Equal, index, int(candidate));
                for (chosen, &scalar) in chosen.iter_mut().zip(element(candidate)) {
                    *chosen = self.code.select(is, scalar, *chosen);
                }
            }
            return Ok(chosen);
        }
        // Through memory, densely.
        let index = self.code.binary(Binary::UnsignedMin, index, int(count - 1));
        let constants: Option<Vec<u32>> = all
            .iter()
            .map(|scalar| match scalar {
                Operand::Constant(_, bits) => Some(*bits),
                Operand::Value(_) => None,
            })
            .collect();
        let array = match constants {
            Some(words) => self.code.words(words),
            None => {
                let memory = self.code.allocate(4 * all.len() as u64);
                let parts = self.dense(all);
                self.store(Place::Memory(memory), &parts, all)?;
                memory
            }
        };
        let parts = self.dense(element(0));
        let stride = 4 * of.scalars as u32;
        let mut place = self.code.element(array, index, stride);
        if place.memory == Memory::Constant {
            // These words never change at all.
            place.binding = None;
        }
        self.load(Place::Memory(place), &parts)
    }

    /// Scalars one after the other.
    pub(super) fn dense(&self, scalars: &[Operand]) -> Vec<Part> {
        (0..)
            .zip(scalars)
            .map(|(index, &scalar)| Part {
                offset: 4 * index,
                ty: self.code.type_of(scalar),
            })
            .collect()
    }
}
