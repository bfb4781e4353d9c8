//! Where values lie, and how they come and go.

use naga::Handle;

use super::{
    Lowering,
    emit::{Address, Operand},
    types::Part,
};
use crate::{
    CompileError, ErrorKind,
    ir::{Memory, Runtime, Variable},
};

/// What a pointer points to.
#[derive(Debug, Clone, Copy)]
pub(super) enum Place {
    /// Variables of the code, one for each scalar, from this one on.
    Variables(Variable),
    Memory(Address),
    /// An image, by its number among the bindings.
    Image(usize),
}

/// What an expression is.
#[derive(Debug, Clone)]
pub(super) enum Evaluated {
    Scalars(Vec<Operand>),
    Place(Place),
}

/// Values of more scalars than this are copied from place to place by one call.
const MOST_COPIED: usize = 32;

impl Lowering<'_> {
    /// Reads all of a place.
    pub(super) fn load(
        &mut self,
        place: Place,
        parts: &[Part],
    ) -> Result<Vec<Operand>, CompileError> {
        Ok(match place {
            Place::Variables(first) => (first.0..)
                .take(parts.len())
                .map(|variable| self.code.get(Variable(variable)))
                .collect(),
            Place::Memory(address) => parts
                .iter()
                .map(|part| self.code.load(address.plus(part.offset), part.ty))
                .collect(),
            Place::Image(_) => return Err(ErrorKind::unsupported("an image as a value")),
        })
    }

    /// Writes all of a place.
    pub(super) fn store(
        &mut self,
        place: Place,
        parts: &[Part],
        values: &[Operand],
    ) -> Result<(), CompileError> {
        match place {
            Place::Variables(first) => {
                for (variable, &value) in (first.0..).zip(values) {
                    self.code.set(Variable(variable), value);
                }
            }
            Place::Memory(address) => self.store_memory(address, parts, values),
            Place::Image(_) => return Err(ErrorKind::unsupported("an image as a variable")),
        }
        Ok(())
    }

    fn store_memory(&mut self, address: Address, parts: &[Part], values: &[Operand]) {
        // Large constants are copied from where they lie beside the code.
        let constants: Option<Vec<u32>> = values
            .iter()
            .map(|value| match value {
                Operand::Constant(_, bits) => Some(*bits),
                Operand::Value(_) => None,
            })
            .collect();
        let dense = parts
            .iter()
            .zip(0..)
            .all(|(part, index)| part.offset == 4 * index);
        if let Some(words) = constants
            && words.len() > MOST_COPIED
            && dense
            && address.memory != Memory::Atomic
        {
            let bytes = self
                .code
                .materialize(super::emit::int(4 * words.len() as u32));
            let target = self.code.pointer(address);
            let source = self.code.words(words);
            let arguments = vec![target, source.base, bytes];
            self.code.runtime_memory(Runtime::Copy, arguments);
            return;
        }
        for (part, &value) in parts.iter().zip(values) {
            self.code.store(address.plus(part.offset), value);
        }
    }

    /// Gives a variable its first value.
    pub(super) fn initialize(
        &mut self,
        place: Place,
        ty: Handle<naga::Type>,
        init: Option<Vec<Operand>>,
    ) -> Result<(), CompileError> {
        if let (Place::Memory(address), None) = (place, &init) {
            let bytes = self.types.size(ty);
            self.code.zero(address, bytes);
            return Ok(());
        }
        let parts = self.types.parts(ty)?;
        let values = match init {
            Some(values) => values,
            None => self.zeros(ty)?,
        };
        self.store(place, &parts, &values)
    }
}
