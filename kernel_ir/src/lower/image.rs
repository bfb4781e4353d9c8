//! Textures: read and written texel by texel. A place outside is restricted to the image; what is written there is lost.

use naga::{Expression, Handle, ImageQuery, ScalarKind, TypeInner};

use super::{
    Lowering,
    emit::{Address, Operand, int},
    function::Frame,
    place::Place,
    types::Part,
};
use crate::{
    CompileError, ErrorKind, Format, ImageHeader, TILE,
    ir::{Binary, Comparison, Label, Memory, Runtime, Type, Variable, context},
};

/// An image's header, as far as it is asked for.
struct Header {
    address: Address,
}

impl<'m> Lowering<'m> {
    fn image(
        &mut self,
        frame: &mut Frame<'m>,
        image: Handle<Expression>,
    ) -> Result<Header, CompileError> {
        let Place::Image(binding) = self.place(frame, image)? else {
            return Err(ErrorKind::unsupported("a texture that is no binding"));
        };
        let entry = self.context_place(context::binding(binding));
        let base = self.code.load(entry, Type::Pointer);
        Ok(Header {
            address: Address {
                base: self.code.materialize(base),
                offset: 0,
                memory: Memory::Constant,
                binding: None,
            },
        })
    }

    fn image_word(&mut self, header: &Header, offset: usize) -> Operand {
        self.code
            .load(header.address.plus(offset as u32), Type::I32)
    }

    pub(super) fn image_load(
        &mut self,
        frame: &mut Frame<'m>,
        image: Handle<Expression>,
        coordinate: Handle<Expression>,
        array_index: Option<Handle<Expression>>,
    ) -> Result<Vec<Operand>, CompileError> {
        let ty = match self.inner(frame, image) {
            TypeInner::Image {
                class: naga::ImageClass::Sampled { kind, .. },
                ..
            } if *kind != ScalarKind::Float => Type::I32,
            TypeInner::Image {
                class: naga::ImageClass::Storage { format, .. },
                ..
            } if naga::Scalar::from(*format).kind != ScalarKind::Float => Type::I32,
            _ => Type::F32,
        };
        let header = self.image(frame, image)?;
        let mut place = self.scalars(frame, coordinate)?;
        place.push(match array_index {
            Some(index) => self.scalar(frame, index)?,
            None => int(0),
        });
        let sizes = [
            std::mem::offset_of!(ImageHeader, width),
            std::mem::offset_of!(ImageHeader, height),
            std::mem::offset_of!(ImageHeader, layers),
        ]
        .map(|offset| self.image_word(&header, offset));
        for (coordinate, &size) in place.iter_mut().zip(&sizes) {
            if *coordinate != int(0) {
                let last = self.code.binary(Binary::Subtract, size, int(1));
                *coordinate = self.code.binary(Binary::UnsignedMin, *coordinate, last);
            }
        }
        let texel = self.texel_place([sizes[0], sizes[1]], place);
        Ok(self.texel(&header, texel, ty))
    }

    /// As [`texel_place`](crate::texel_place).
    fn texel_place(&mut self, size: [Operand; 2], place: Vec<Operand>) -> Operand {
        let shift = int(TILE.trailing_zeros());
        let [across, down] = size.map(|size| {
            let padded = self.code.binary(Binary::Add, size, int(TILE - 1));
            self.code.binary(Binary::UnsignedShiftRight, padded, shift)
        });
        let [column, row] = [place[0], place[1]].map(|at| {
            let tile = self.code.binary(Binary::UnsignedShiftRight, at, shift);
            (tile, self.code.binary(Binary::And, at, int(TILE - 1)))
        });
        let tile_rows = self.code.binary(Binary::Multiply, place[2], down);
        let tile_row = self.code.binary(Binary::Add, tile_rows, row.0);
        let first = self.code.binary(Binary::Multiply, tile_row, across);
        let tile = self.code.binary(Binary::Add, first, column.0);
        let rows = self.code.binary(Binary::ShiftLeft, tile, shift);
        let rows = self.code.binary(Binary::Or, rows, row.1);
        let start = self.code.binary(Binary::ShiftLeft, rows, shift);
        self.code.binary(Binary::Or, start, column.1)
    }

    /// Four words are read where they are; other formats take a call.
    fn texel(&mut self, header: &Header, texel: Operand, ty: Type) -> Vec<Operand> {
        let parts: Vec<Part> = (0..4)
            .map(|index| Part {
                offset: 4 * index,
                ty,
            })
            .collect();
        let results = self.code.variables(&parts);
        let mark = self.code.mark();
        let memory = self.code.allocate(16);
        let (wide, narrow, join) = (
            self.code.new_label(),
            self.code.new_label(),
            self.code.new_label(),
        );
        let format = self.image_word(header, std::mem::offset_of!(ImageHeader, format));
        let is_wide = self.code.compare(
            Comparison::UnsignedLessEqual,
            format,
            int(Format::Rgba32Uint as u32),
        );
        self.code.branch(is_wide, wide, narrow);

        self.code.label(wide);
        let texels = header
            .address
            .plus(std::mem::offset_of!(ImageHeader, texels) as u32);
        let base = self.code.load(texels, Type::Pointer);
        let array = Address {
            base: self.code.materialize(base),
            offset: 0,
            // It may be a storage texture.
            memory: Memory::Plain,
            binding: None,
        };
        let place = self.code.element(array, texel, 16);
        self.texel_to(results, place, &parts, join);

        self.code.label(narrow);
        let index = self.code.materialize(texel);
        let arguments = vec![header.address.base, index, memory.base];
        self.code.runtime_memory(Runtime::LoadTexel, arguments);
        self.texel_to(results, memory, &parts, join);

        self.code.label(join);
        self.code.release(mark);
        (results.0..results.0 + 4)
            .map(|variable| self.code.get(Variable(variable)))
            .collect()
    }

    fn texel_to(&mut self, results: Variable, place: Address, parts: &[Part], join: Label) {
        for (variable, part) in (results.0..).zip(parts) {
            let word = self.code.load(place.plus(part.offset), part.ty);
            self.code.set(Variable(variable), word);
        }
        self.code.jump(join);
    }

    pub(super) fn image_store(
        &mut self,
        frame: &mut Frame<'m>,
        image: Handle<Expression>,
        coordinate: Handle<Expression>,
        array_index: Option<Handle<Expression>>,
        value: Handle<Expression>,
    ) -> Result<(), CompileError> {
        let header = self.image(frame, image)?;
        let mut place = self.scalars(frame, coordinate)?;
        place.push(match array_index {
            Some(index) => self.scalar(frame, index)?,
            None => int(0),
        });
        let value = self.scalars(frame, value)?;
        let mark = self.code.mark();
        let memory = self.code.allocate(16);
        let parts = self.dense(&value);
        self.store(Place::Memory(memory), &parts, &value)?;
        let mut arguments = vec![header.address.base];
        for coordinate in place {
            arguments.push(self.code.materialize(coordinate));
        }
        arguments.push(memory.base);
        self.code.runtime_memory(Runtime::StoreTexel, arguments);
        self.code.release(mark);
        Ok(())
    }

    pub(super) fn image_query(
        &mut self,
        frame: &mut Frame<'m>,
        image: Handle<Expression>,
        query: ImageQuery,
    ) -> Result<Vec<Operand>, CompileError> {
        let header = self.image(frame, image)?;
        Ok(match query {
            ImageQuery::Size { .. } => {
                // Two numbers of the one level that there is.
                let width = self.image_word(&header, std::mem::offset_of!(ImageHeader, width));
                let height = self.image_word(&header, std::mem::offset_of!(ImageHeader, height));
                vec![width, height]
            }
            ImageQuery::NumLayers => {
                vec![self.image_word(&header, std::mem::offset_of!(ImageHeader, layers))]
            }
            ImageQuery::NumLevels | ImageQuery::NumSamples => vec![int(1)],
        })
    }
}
